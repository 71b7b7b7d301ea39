// A prior of a robot's numbers: what the rig file says of each, give or take ten times the
// change that is plausible for its kind (ParameterInfo::change). Without it a fit of an arm
// whose last joints the tool hardly shows walks along a bent valley for ever, far from any
// robot. It is too wide to move what the data determine: a link that these know to 0.01 mm
// moves towards the file by a millionth of the way. It steers the fit and is no part of the
// evidence.
#pragma once

#include <Eigen/Core>
#include <span>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

struct PlausibleRobot {
  Eigen::VectorXd at;  // of the model's numbers [mm, rad]; empty: nothing is assumed
  /// 1 / (standard deviation) [1/mm, 1/rad]; 0: where the robot stands, and what is not its
  /// own. Empty: of no number.
  Eigen::VectorXd per_sd;
  /// The same of sums of numbers, sums x numbers: Readings::held().
  Eigen::MatrixXd held;

  /// Sum of ((x - at) / sd)^2.
  [[nodiscard]] double squares(const simulation::ModelVector& x) const;
};

/// Of robots in space; in the plane only what the readings are told to hold, as there the poses
/// of most sessions determine all. `numbers`: of the model, the robot's first.
[[nodiscard]] PlausibleRobot plausible_robot(const Readings& readings, Eigen::Index numbers);

/// Directions of the robot's numbers that these trials leave open, as `calibrate` would hold
/// them (calibration/identifiability.h), for Readings::hold(); none: 0 x 0. `rig`: with dials.
[[nodiscard]] Eigen::MatrixXd open_directions(
    std::span<const simulation::Trial> trials, const simulation::ForwardModel& model);

}  // namespace sixdial::diagnosis
