#include "acquisition/robot.h"

namespace sixdial::acquisition {

tl::expected<RobotState, RobotFault> ManualRobot::state(const std::stop_token&) {
  return state_;
}

tl::expected<RobotState, RobotFault> ManualRobot::move_to(
    const Eigen::VectorXd& q, std::chrono::milliseconds, const std::stop_token& stop) {
  const auto answer = ask_(q, stop);
  if (!answer) {
    return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, "nobody confirmed the move"});
  }
  if (!answer->done) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kUnreachable, "the operator says the point cannot be reached"});
  }
  ++state_.moves;
  state_.motion = Motion::kInPosition;
  state_.q = answer->q.value_or(q);
  state_.temperature_c = answer->temperature_c;
  return state_;
}

}  // namespace sixdial::acquisition
