// How well a robot is known over its workspace once it is registered: what a motion of the
// whole robot would do as well is left out, as where it stands is found where it is put to
// work.
//
//   J_k = dp_k/dv less the rigid motion of all poses that comes nearest to it
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/workspace.h"

namespace sixdial::calibration {

class RegisteredWorkspace {
 public:
  /// Poses that v cannot reach are left out. In space; `tool` has three coordinates.
  RegisteredWorkspace(
      const geometry::Tool& tool, const Eigen::VectorXd& v,
      std::span<const WorkspacePose> poses);

  /// For a covariance of the robot's parameters.
  [[nodiscard]] WorkspaceUncertainty uncertainty(const Eigen::MatrixXd& P) const;
  /// Mean of J' J: trace(JJ P) is the mean variance of the position.
  [[nodiscard]] Eigen::MatrixXd mean_sensitivity() const;

 private:
  std::vector<Eigen::MatrixXd> J_;  // 3 x parameters, one a pose
  Eigen::Index parameters_ = 0;
};

}  // namespace sixdial::calibration
