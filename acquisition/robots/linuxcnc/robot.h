// A robot that LinuxCNC moves, by its remote linuxcncrsh: lines of text over TCP, port 5007.
// With trivial kinematics (each axis a joint), in the coordinates of the machine: X, Y, Z, A,
// B, C.
//
//   set mdi G21 G90 G94 G53 G1 X57.29578 F600    to the target; taken at once
//   get program_status                           IDLE once it has ended
//   get abs_act_pos                              where it stands, by the encoders
//   set abort                                    stops it
#pragma once

#include <array>
#include <map>

#include "acquisition/robots/axis_robot.h"
#include "acquisition/robots/linuxcnc/lines.h"

namespace sixdial::acquisition {

inline constexpr int kCncPort = 5007;

struct CncPasswords {
  std::string connect = "EMC";
  std::string enable = "EMCTOO";
};

class LinuxCncRobot final : public AxisRobot {
 public:
  LinuxCncRobot(
      AxisSettings settings, CncPasswords passwords, Open open, Clock& clock,
      std::span<const RobotJoint> joints);
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;

 private:
  enum class Program { kIdle, kRunning, kPaused };
  /// What a look at the machine shows.
  struct Look {
    std::vector<double> stands{};  // [deg, mm], in the order of the axes
    Program program = Program::kIdle;
    std::optional<RobotFault> locked{};  // emergency stop, switched off, not homed
    std::string error{};                 // since the last look; empty: none
  };
  using Values = std::map<std::string, std::string>;

  OrFault<RobotState> state_now(const std::stop_token& stop) override;
  OrFault<RobotState> go_to(
      const std::vector<double>& target, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  OrFault<CncLine> line_by(
      WallTime deadline, std::string_view asked, const std::stop_token& stop);
  /// "set NAME WHAT", and its acknowledgement.
  OrFault<void> set(std::string_view name, std::string_view what, const std::stop_token& stop);
  /// All of `names` at once.
  OrFault<Values> get(std::span<const std::string_view> names, const std::stop_token& stop);
  OrFault<void> hello(const std::stop_token& stop);
  OrFault<void> come_into_step(const std::stop_token& stop);
  OrFault<void> learn_units(const std::stop_token& stop);
  OrFault<void> ready(const std::stop_token& stop);
  OrFault<Look> look(const std::stop_token& stop);
  OrFault<std::vector<double>> stands_at(const std::string& text);
  [[nodiscard]] std::optional<RobotFault> locked(const Values& values) const;
  OrFault<void> ready_to_move(const std::stop_token& stop);
  OrFault<Look> wait_for_end(
      const std::vector<double>& target, WallTime deadline, const std::stop_token& stop);
  OrFault<void> wait_until_idle(const std::stop_token& stop);
  [[nodiscard]] RobotState shown_by(const Look& seen) const;

  const CncPasswords passwords_;
  bool in_step_ = false;  // its next answer is that to the next question
  double linear_ = 1.0;   // mm in one of the machine's units
  double angular_ = 1.0;  // deg
};

}  // namespace sixdial::acquisition
