#include "acquisition/robots/manual_robot.h"

#include "acquisition/connection_text.h"
#include "acquisition/robot_driver.h"

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

namespace {

OpenRobot parse(std::string_view rest, std::span<const RobotJoint>) {
  if (!rest.empty()) refuse("nothing follows 'manual'");
  return [](const RobotSite& site) { return std::make_unique<ManualRobot>(site.ask); };
}

}  // namespace

extern constinit const RobotDriver manual_robot{
    .scheme = "manual",
    .form = "manual",
    .in_words = "nothing: a person moves the robot and confirms on the screen",
    .by_hand = true,
    .parse = parse};

}  // namespace sixdial::acquisition
