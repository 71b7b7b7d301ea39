// The controller's reduced speed during a first pass, and how a joint is brought by hand. (A
// robot is halted by Collection::halt_robot; the person is asked in
// acquisition/collector_guard.h.) Only for the sources of Collection.
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
