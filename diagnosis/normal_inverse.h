// All unknowns of a joint fit at once, parameters and random columns: how the readings move
// them, and how well they are known.
#pragma once

#include <Eigen/Core>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

struct NormalInverse {
  explicit NormalInverse(const JointFit& fit);

  /// Change of the parameters is estimate * rows' * (whitened change of the readings).
  Eigen::MatrixXd rows;      // readings x unknowns, whitened and scaled
  Eigen::MatrixXd estimate;  // parameters x unknowns
  /// Of the random columns where each u is measured in s of its prior (JointFit::scaled_u), in
  /// units of s^2; m x m.
  Eigen::MatrixXd covariance_of_u;
  /// Directions of the parameters that no reading shows, a basis; parameters x any. `estimate`
  /// leaves them where they are. A parameter without any slope is held and not among them.
  Eigen::MatrixXd unseen;
};

}  // namespace sixdial::diagnosis
