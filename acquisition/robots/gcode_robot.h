// A robot whose controller takes G-code line by line, in the coordinates that G1 has there.
//
//   G1 X57.29578 Y-11.45916 F600    to the target, in a straight line of the joints
//   G4 P0.01 (Grbl), M400           answered once it is there
//   ?        (Grbl), M114           where it stands
#pragma once

#include <atomic>
#include <string_view>
#include <vector>

#include "acquisition/robots/axis_robot.h"
#include "acquisition/robots/gcode/dialect.h"

namespace sixdial::acquisition {

class GcodeRobot final : public AxisRobot {
 public:
  /// `dialect` outlives the robot. `boot`: so long a controller may need after its port was
  /// opened (an Arduino begins anew).
  GcodeRobot(
      AxisSettings settings, const GcodeDialect* dialect, std::chrono::milliseconds boot,
      Open open, Clock& clock, std::span<const RobotJoint> joints);
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;

 private:
  /// What a look at the machine shows.
  struct Look {
    std::vector<double> stands{};  // [deg, mm], in the order of the axes
    Motion motion = Motion::kInPosition;
  };

  OrFault<RobotState> state_now(const std::stop_token& stop) override;
  OrFault<RobotState> go_to(
      const std::vector<double>& target, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  /// The line stays open: a controller may begin anew, and lose its place, when it is opened.
  void lose_step() override { in_step_ = false; }

  OrFault<void> open_line();
  OrFault<void> ready(const std::stop_token& stop);
  /// Reads and drops what is still under way.
  OrFault<void> quiet_down(const std::stop_token& stop);
  /// Its next answer is that to the next question, whatever else has become of it.
  OrFault<void> catch_up(const std::stop_token& stop);
  OrFault<void> greet(const std::stop_token& stop);
  OrFault<void> drop_halted_move(const std::stop_token& stop);
  /// Empty: none came by then.
  OrFault<std::optional<GcodeLine>> line_by(WallTime deadline, const std::stop_token& stop);
  /// The next line after `asked`.
  OrFault<GcodeLine> next_line(
      WallTime deadline, std::string_view asked, const std::stop_token& stop);
  OrFault<void> command(std::string_view line, WallTime deadline, const std::stop_token& stop);
  OrFault<GcodeLine> report(const std::stop_token& stop);
  OrFault<Look> look(const std::stop_token& stop);
  OrFault<std::vector<double>> stands_at(const GcodeLine& line);
  OrFault<void> wait_for_end(WallTime deadline, const std::stop_token& stop);
  [[nodiscard]] RobotState shown_by(const Look& seen) const;

  const GcodeDialect& dialect_;
  const std::chrono::milliseconds boot_;
  std::atomic<bool> in_step_{false};  // its answers are those to what was asked
  std::vector<AxisFigure> offset_;    // machine less commands, as it was told last
  std::vector<double> sent_;          // [deg, mm]; empty: nowhere since it was opened
};

}  // namespace sixdial::acquisition
