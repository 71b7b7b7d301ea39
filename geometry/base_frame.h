// The base frame of a robot of any kind among its parameters: which of them stand for where it
// is and how it is turned, and their values when it stands elsewhere. No kind is asked by name:
// a motion of the base moves every pose in the same way, and the derivatives of the tool tell
// which change of the parameters does that.
//
//   f(with_base_moved(v, X), q) = X f(v, q)   for all q
//
// Example:
//   Similarity X = Similarity::identity(2);
//   X.t = Eigen::Vector2d(0.0, 250.0);
//   std::vector<JointPose> poses;
//   for (const auto& trial : trials) poses.push_back({trial.q, trial.assembly});
//   const auto moved = with_base_moved(Tool(rig), rig.robot.nominal, X, poses);
//   if (moved) show((*moved)[6]);  // y0, 250 mm further; empty: this kind has none
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "geometry/registration.h"
#include "geometry/tool.h"

namespace sixdial::geometry {

/// Joint values and the assembly of one pose.
struct JointPose {
  Eigen::VectorXd q;
  Assembly assembly = Assembly::kLeft;
};

/// The parameters of the same robot on a base that was moved by X, a turn and a shift. `poses`
/// stand for what the robot can do: a few dozen, spread over its work. Empty where its
/// parameters cannot move the base so, or none of the poses can be reached.
[[nodiscard]] std::optional<Eigen::VectorXd> with_base_moved(
    const Tool& tool, const Eigen::VectorXd& v, const Similarity& X,
    std::span<const JointPose> poses);

}  // namespace sixdial::geometry
