// A prior of a robot's numbers: what the rig file says of each, give or take ten times the
// change that is plausible for its kind (ParameterInfo::change). Without it a fit of an arm
// whose last joints the tool hardly shows walks along a bent valley for ever, far from any
// robot. It is too wide to move what the data determine: a link that these know to 0.01 mm
// moves towards the file by a millionth of the way. It steers the fit and is no part of the
// evidence.
#pragma once

#include <Eigen/Core>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

struct PlausibleRobot {
  Eigen::VectorXd at;  // of the model's numbers [mm, rad]; empty: nothing is assumed
  /// 1 / (standard deviation) [1/mm, 1/rad]; 0: where the robot stands, and what is not its
  /// own.
  Eigen::VectorXd per_sd;

  /// Sum of ((x - at) / sd)^2.
  [[nodiscard]] double squares(const simulation::ModelVector& x) const;
};

/// Of robots in space; in the plane the poses of a session determine all. `numbers`: of the
/// model, the robot's first.
[[nodiscard]] PlausibleRobot plausible_robot(const Readings& readings, Eigen::Index numbers);

}  // namespace sixdial::diagnosis
