// Joint values for a pose by Newton's steps, for kinds of robot in space that have no closed
// form: the step of the least change of the joints, damped where it would not help. Of six and
// more joints a pose is reached, of fewer a place (the turn then is what it comes to).
//
// Accuracy: 1e-10 of the robot's size. Starts at `near`, else at the middle of the joints'
// usual ranges, then at drawn values; kOutOfReach where none of them arrives.
#pragma once

#include <Eigen/Core>
#include <span>
#include <tl/expected.hpp>

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

/// As RobotKind::inverse (X_WE.R of NaN: turned as it comes), for robots with one assembly (the
/// first is used). Revolute joints that no other follows are given within half a turn of
/// `near`.
[[nodiscard]] tl::expected<Eigen::VectorXd, KinematicTrouble> inverse_by_steps(
    const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE,
    std::span<const double> near);

}  // namespace sixdial::geometry
