// A robot that Klipper moves, by the API server of its host program: JSON over a Unix socket.
// In the coordinates of its own G1; X, Y, Z.
//
//   gcode/script "G1 X57.29578 F600", ..., "M400"    to the target; M400 is answered there
//   objects/query                                    where it stands, how it is, meanwhile too
//
// Klipper cannot drop a move that it has, but for its emergency stop. So a move is given to it
// in pieces of a quarter of a second, which it runs through without slowing down in between; a
// stop gives it no more of them. It plans up to two seconds ahead: so long it goes on.
#pragma once

#include "acquisition/robots/axis_robot.h"
#include "acquisition/robots/klipper/message.h"

namespace sixdial::acquisition {

/// As long as one piece of a move lasts.
inline constexpr double kKlipperPiece_s = 0.25;
/// Klipper plans so far ahead; after a stop it goes on for as long, and slows down.
inline constexpr std::chrono::milliseconds kKlipperAhead{4000};

class KlipperRobot final : public AxisRobot {
 public:
  KlipperRobot(
      AxisSettings settings, Open open, Clock& clock, std::span<const RobotJoint> joints);
  /// Gives it no more of a move. Where none of this program's runs: an error if the machine
  /// moves, as only its emergency stop ends that.
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;

 private:
  OrFault<RobotState> state_now(const std::stop_token& stop) override;
  OrFault<RobotState> go_to(
      const std::vector<double>& target, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  OrFault<void> ready(const std::stop_token& stop);
  OrFault<std::optional<KlipperMessage>> message_by(
      WallTime deadline, const std::stop_token& stop);
  OrFault<KlipperMessage> answer_to(
      std::int64_t id, std::string_view asked, const std::stop_token& stop);
  OrFault<KlipperStatus> status(const std::stop_token& stop);
  OrFault<void> script(const std::string& text, WallTime deadline, const std::stop_token& stop);
  OrFault<void> move_in_pieces(
      const std::vector<double>& from, const std::vector<double>& target, WallTime deadline,
      const std::stop_token& stop);
  OrFault<std::vector<double>> ready_to_move(
      const std::vector<double>& target, const std::stop_token& stop);
  [[nodiscard]] RobotState shown_by(const KlipperStatus& status) const;
  [[nodiscard]] std::vector<double> stands_at(const KlipperStatus& status) const;
  [[nodiscard]] std::optional<RobotFault> not_ready(const KlipperStatus& status) const;
  [[nodiscard]] std::optional<RobotFault> beyond(
      const KlipperStatus& status, const std::vector<double>& target) const;

  std::int64_t last_id_ = 0;
};

}  // namespace sixdial::acquisition
