// How far a predicted position can be from where the tool goes. Structure moves both: the
// parameters that were fitted to it, and the tool itself at the place that is asked for,
//
//   f(x^, q) - true = J_v (x^ - x) - s(q),   x^ - x = A (s + noise),
//
// so that what the parameters took over of it is not missed there, however large it is.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/uncertainty.h"

namespace sixdial::calibration {

class PredictedPosition {
 public:
  /// As estimates_with_noise has it. `sigma_mm`: noise where no structure is seen.
  PredictedPosition(
      const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
      double sigma_mm, const Structure& structure);

  /// axes x axes [mm^2]. `J_v`: d(position)/d(parameters of the robot), which come first in x.
  [[nodiscard]] Eigen::MatrixXd covariance(
      const Eigen::VectorXd& joints, const Eigen::MatrixXd& J_v) const;

 private:
  struct Part {
    double weight = 1.0, sd_mm = 0.0, noise_mm = 0.0;
    bool moves_tool = false;  // else a channel's own error: none of the tool's
    bool over_joints = false;
    std::vector<SmoothBasis> basis;  // one, or none without structure
    Eigen::MatrixXd moved;           // parameters x coefficients
  };
  Eigen::MatrixXd noise_;  // of the parameters, for rows of variance 1
  Eigen::MatrixXd rig_;    // how far each quantity of the rig moves the parameters
  std::vector<Part> parts_;
};

/// position_uncertainty with the covariance of each place by `predicted`.
[[nodiscard]] PositionUncertainty position_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const PredictedPosition& predicted,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, int columns = 13, int rows = 19);

}  // namespace sixdial::calibration
