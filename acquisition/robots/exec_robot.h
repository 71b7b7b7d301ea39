// A robot that a command of the user's own moves: exit code 0 and it is there.
#pragma once

#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/robot.h"

namespace sixdial::acquisition {

/// Exit code of a command whose target cannot be reached: the point is left out, the run goes
/// on. Any other but 0 pauses it.
inline constexpr int kUnreachableExit = 10;

/// Any thread; one command at a time.
class ExecRobot final : public RobotPort {
 public:
  /// `words` by exec_words. `clock` must outlive the robot.
  ExecRobot(std::vector<std::string> words, Clock& clock, std::span<const RobotJoint> joints);
  /// Where the last command said that it is.
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  /// Kills the command, SIGTERM first. An error: none runs.
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;
  /// Empty where the command does not say {speed_percent}.
  [[nodiscard]] tl::expected<std::optional<int>, RobotFault> speed(
      const std::stop_token& stop) override;
  /// Refused where the command does not say {speed_percent}.
  [[nodiscard]] tl::expected<void, RobotFault> set_speed(
      int percent, const std::stop_token& stop) override;

 private:
  const std::vector<std::string> words_;
  const std::vector<RobotJoint> joints_;
  const bool knows_speed_;
  Clock& clock_;
  std::mutex mutex_;  // of what follows
  RobotState state_;
  int percent_ = 100;
  std::optional<std::stop_source> running_;
};

}  // namespace sixdial::acquisition
