// Where the tool of any robot is, in as many coordinates as its position is measured in, how
// that changes with joints and parameters, and back: joint values for a place. What only some
// kinds can say (an inverse, the mode of a pose) is asked of the kind's optional members.
//
//   const Tool tool(rig);
//   if (const auto at = tool.position(rig.robot.nominal, q, rig.robot.assembly)) use(*at);
//
// Frame W, mm and rad. Immutable: several threads may ask at once.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <tl/expected.hpp>

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

struct Rig;

struct ToolDerivative {
  Position p_WE;
  Eigen::MatrixXd J_v;  // dp_WE/dv, axes x parameters
  Eigen::MatrixXd J_q;  // dp_WE/dq, axes x joints
};

class Tool {
 public:
  /// `axes`: 2 or 3.
  Tool(std::shared_ptr<const RobotModel> robot, int axes);
  /// In the coordinates in which the rig measures positions.
  explicit Tool(const Rig& rig);

  [[nodiscard]] int axes() const { return axes_; }
  [[nodiscard]] const RobotModel& robot() const { return *robot_; }
  [[nodiscard]] bool has_inverse() const { return robot_->kind->inverse != nullptr; }

  [[nodiscard]] tl::expected<Position, KinematicTrouble> position(
      const Values& v, const Values& q, Assembly assembly) const;
  [[nodiscard]] tl::expected<ToolDerivative, KinematicTrouble> derivative(
      const Values& v, const Values& q, Assembly assembly) const;
  /// Joint values that put the tool there, as RobotKind::inverse; in space turned as it is at
  /// `near`. kNoInverse if the kind has none.
  [[nodiscard]] tl::expected<Eigen::VectorXd, KinematicTrouble> inverse(
      const Values& v, const Values& p_WE, WorkingMode mode,
      const std::optional<Eigen::VectorXd>& near = std::nullopt) const;
  /// The assembly that puts the tool of these joint values nearest to p_WE. Fails where none
  /// has a pose.
  [[nodiscard]] tl::expected<Assembly, KinematicTrouble> assembly_at(
      const Values& v, const Values& q, const Values& p_WE) const;
  /// The mode that a pose is in: the kind's own word, else the one whose inverse is nearest.
  [[nodiscard]] tl::expected<WorkingMode, KinematicTrouble> mode_of(
      const Values& v, const Values& q, Assembly assembly) const;

 private:
  std::shared_ptr<const RobotModel> robot_;
  int axes_;
};

/// The tool in the plane, the heading of the frame `link`, if one is asked for, and, unless
/// null, d(p_WE)/dq. By the kind's own short way, if it has one.
[[nodiscard]] tl::expected<PlanarPose, KinematicTrouble> planar_pose(
    const RobotModel& robot, const Values& v, const Values& q, Assembly assembly,
    std::optional<int> link, Eigen::Matrix2Xd* J_q = nullptr);

}  // namespace sixdial::geometry
