// The parts of a collection that are about safety: the first pass, its speed, and the robot's
// halt. Only for the sources of Collection.
#pragma once

#include <optional>

#include "acquisition/robot.h"
#include "service/collection_run.h"

namespace sixdial::service {

/// How far away a person brings a joint first, so that it surely arrives from one side.
inline constexpr double kApproachByHand_rad = 0.035;

/// The controller's speed while it lives, in percent; as before at its end.
class ReducedSpeed {
 public:
  /// Throws Error device where the controller does not take it: then nothing may move.
  ReducedSpeed(acquisition::RobotPort& robot, std::optional<int> percent);
  ~ReducedSpeed();
  ReducedSpeed(const ReducedSpeed&) = delete;
  ReducedSpeed& operator=(const ReducedSpeed&) = delete;

 private:
  acquisition::RobotPort& robot_;
  std::optional<int> before_;
};

}  // namespace sixdial::service
