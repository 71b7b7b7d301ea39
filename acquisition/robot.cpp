#include "acquisition/robot.h"

namespace sixdial::acquisition {

std::string_view describe(RobotFaultKind kind) {
  switch (kind) {
    case RobotFaultKind::kLink:
      return "the robot controller does not answer";
    case RobotFaultKind::kUnreachable:
      return "the robot cannot reach the target";
    case RobotFaultKind::kHalted:
      return "the robot was stopped";
    case RobotFaultKind::kNotThere:
      return "the robot did not arrive in time";
    case RobotFaultKind::kController:
      return "the robot controller reports a fault";
    case RobotFaultKind::kCancelled:
      return "the move was cancelled";
  }
  return "unknown robot fault";
}

}  // namespace sixdial::acquisition
