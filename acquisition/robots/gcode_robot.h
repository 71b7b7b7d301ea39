// A robot whose controller takes G-code, each joint an axis: a turning joint in degrees, a
// linear one in mm, in the coordinates that G1 has there.
//
//   G1 X57.29578 Y-11.45916 F600    to the target, in a straight line of the joints
//   G4 P0.01 (Grbl), M400           answered once it is there
//   ?        (Grbl), M114           where it stands
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/line_channel.h"
#include "acquisition/robot.h"
#include "acquisition/robots/gcode/dialect.h"

namespace sixdial::acquisition {

/// So long a line may take no bytes [wall].
inline constexpr std::chrono::milliseconds kGcodeWrite{500};

struct GcodeSettings {
  const GcodeDialect* dialect = nullptr;
  std::string axes;                         // the letter of each joint, in the rig's order
  double feed = 600.0;                      // at full speed, deg or mm a minute
  double arrived = 0.05;                    // how far from its target a joint may end [deg, mm]
  std::chrono::milliseconds timeout{2000};  // for an answer that needs no move [device time]
  /// So long a controller may need after its port was opened (an Arduino begins anew).
  std::chrono::milliseconds boot{4000};
  std::string place{};  // for messages: "/dev/ttyUSB0", "10.0.0.7:23"
};

/// Any thread; one exchange at a time, but halt() goes through at once.
class GcodeRobot final : public RobotPort {
 public:
  using Open = std::function<tl::expected<std::unique_ptr<LineChannel>, Fault>()>;
  /// As many joints as `settings.axes` has letters. `clock` must outlive the robot.
  GcodeRobot(
      GcodeSettings settings, std::span<const RobotJoint> joints, Open open, Clock& clock);
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;
  [[nodiscard]] std::chrono::milliseconds silent_for() const override;
  [[nodiscard]] tl::expected<std::optional<int>, RobotFault> speed(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<void, RobotFault> set_speed(
      int percent, const std::stop_token& stop) override;

 private:
  template <typename T>
  using OrFault = tl::expected<T, RobotFault>;
  using WallTime = std::chrono::steady_clock::time_point;

  OrFault<void> ready(const std::stop_token& stop);
  OrFault<void> greet(const std::stop_token& stop);
  OrFault<void> drop_halted_move(const std::stop_token& stop);
  OrFault<void> tell(std::string_view bytes);
  OrFault<GcodeLine> next_line(WallTime deadline, const std::stop_token& stop);
  OrFault<void> command(std::string_view line, WallTime deadline, const std::stop_token& stop);
  OrFault<GcodeLine> report(const std::stop_token& stop);
  OrFault<void> wait_for_end(WallTime deadline, const std::stop_token& stop);
  OrFault<RobotState> state_now(const std::stop_token& stop);
  OrFault<Eigen::VectorXd> joint_values(GcodeLine& line);
  [[nodiscard]] std::string move_line(const Eigen::VectorXd& q);
  [[nodiscard]] std::optional<RobotFault> not_there(const RobotState& state) const;
  [[nodiscard]] RobotFault link_fault(const Fault& fault) const;
  [[nodiscard]] WallTime answer_by() const;
  void quiet_down(const std::stop_token& stop);
  void note_answer(bool came);

  const GcodeSettings settings_;
  const std::vector<RobotJoint> joints_;
  const Open open_;
  Clock& clock_;

  std::mutex mutex_;        // an exchange
  std::mutex write_mutex_;  // bytes out, and channel_; taken after mutex_
  std::unique_ptr<LineChannel> channel_;
  std::atomic<bool> in_step_{false};  // its answers are those to what was asked
  std::atomic<bool> halted_{false};
  std::vector<AxisFigure> offset_;  // machine less commands, as it was told last
  std::vector<double> commanded_;   // [deg, mm]; empty: nothing since it was opened
  std::uint16_t moves_ = 0;
  std::atomic<int> percent_{100};
  std::atomic<DeviceTime::rep> silent_since_{0};  // 0: it answers
};

}  // namespace sixdial::acquisition
