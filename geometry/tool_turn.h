// How a robot's tool is turned: whether its joints can turn it any way, joint values for a
// place and a turn, and the tool's frame on the last link among the parameters. No kind is
// asked by name: the derivatives of the tool's frame tell.
//
//   X(with_tool_turned(v, R), q) = X(v, q) R   about the tool's own point, for all q
//
// Example:
//   // Two joints cannot turn a tool any way, and a pin in a bearing has no turn of its own.
//   reaches_any_turn(*rig.robot.model, rig.robot.nominal);  // -> false
//   turns_its_tool(*rig.robot.model, rig.robot.nominal);  // -> false
#pragma once

#include <Eigen/Core>
#include <optional>
#include <tl/expected.hpp>

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

/// Whether six or more joints move the tool in six independent directions somewhere in their
/// usual ranges, and the kind has an inverse.
[[nodiscard]] bool reaches_any_turn(const RobotModel& robot, const Eigen::VectorXd& v);

/// Joint values that put the tool's frame there, in a robot that reaches_any_turn; as
/// RobotKind::inverse.
[[nodiscard]] tl::expected<Eigen::VectorXd, KinematicTrouble> joints_for_pose(
    const RobotModel& robot, const Eigen::VectorXd& v, const Pose<double>& X_WE,
    WorkingMode mode, const std::optional<Eigen::VectorXd>& near = std::nullopt);

/// The parameters of the same robot whose tool's frame is turned by R on the last link, its
/// point where it was: at joint values drawn from all of the joints' usual ranges, so that no
/// other parameter passes for such a turn. Empty: its parameters cannot do that.
[[nodiscard]] std::optional<Eigen::VectorXd> with_tool_turned(
    const RobotModel& robot, const Eigen::VectorXd& v, const Eigen::Matrix3d& R);

/// Whether they can: what an instrument says of the tool's turn tells parameters then.
[[nodiscard]] bool turns_its_tool(const RobotModel& robot, const Eigen::VectorXd& v);

/// R_WE: how the tool is turned at these joint values. Fails as RobotModel::forward does.
[[nodiscard]] tl::expected<Eigen::Matrix3d, KinematicTrouble> turn_of_tool(
    const RobotModel& robot, const Eigen::VectorXd& v, const Eigen::VectorXd& q,
    Assembly assembly);

/// The turn [rad] by which two frames differ, 0 to pi.
[[nodiscard]] double turn_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

}  // namespace sixdial::geometry
