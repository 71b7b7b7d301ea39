// A robot that a person moves.
#pragma once

#include <functional>
#include <optional>

#include "acquisition/robot.h"

namespace sixdial::acquisition {

/// What a person says after moving the robot.
struct ManualAnswer {
  bool done = true;                  // false: this point cannot be reached
  std::optional<Eigen::VectorXd> q;  // as shown by the encoders; else as asked for
  std::optional<double> temperature_c;
};

class ManualRobot final : public RobotPort {
 public:
  /// Asks a person to bring the joints to q and comes back with the answer; empty if
  /// stopped or timed out. Called from the collector's thread.
  using Ask = std::function<std::optional<ManualAnswer>(
      const Eigen::VectorXd& q, const std::stop_token& stop)>;
  explicit ManualRobot(Ask ask) : ask_(std::move(ask)) {}
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) override;
  /// No time limit: people take the time they need.
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  [[nodiscard]] bool by_hand() const override { return true; }
  void announce_approach(const std::optional<Eigen::VectorXd>& from) override {
    approach_from_ = from;
  }
  /// Where the person said last that it is; empty: nobody has.
  [[nodiscard]] std::optional<Eigen::VectorXd> stands_at() const {
    return state_.q.size() > 0 ? std::optional(state_.q) : std::nullopt;
  }
  /// For what asks: from its call on.
  [[nodiscard]] const std::optional<Eigen::VectorXd>& approach_from() const {
    return approach_from_;
  }

 private:
  Ask ask_;
  RobotState state_;
  std::optional<Eigen::VectorXd> approach_from_;
};

}  // namespace sixdial::acquisition
