// Judges each measured position by what all others predict of it: the fitted robot, and what
// neighbouring poses share that the model misses. The test is exact for normal noise: the
// deletion residual e of a sample and its covariance allow for the sample's own pull on the fit
// (its leverage), and the noise is estimated without it (Cook and Weisberg 1982, 2.2), so that
//
//   F = e' C^-1 e / k   is distributed as F(k, degrees of freedom left), k coordinates.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/fit_covariance.h"
#include "calibration/least_squares.h"
#include "calibration/observation_space.h"

namespace sixdial::calibration {

class PositionJudge {
 public:
  struct Verdict {
    double size_mm = 0.0;      // distance from what the others predict
    double times_sigma = 0.0;  // the same in standard deviations, sqrt(e' C^-1 e)
    double chance = 1.0;       // that noise alone makes it so large
  };

  /// Whether each sample of the space has one row for each coordinate of the tool.
  [[nodiscard]] static bool can_judge(const ObservationSpace& space);

  /// `space`: positions, or others that it can judge; `fit` minimised
  /// space.problem(Weighting::kByCovariance), so that each sample counts by its own precision
  /// where that is known.
  PositionJudge(const ObservationSpace& space, const LeastSquaresFit& fit);

  /// Each sample of the space by all the others.
  [[nodiscard]] std::vector<Verdict> each_by_the_others() const;
  /// Each sample of another space, none of whose samples were fitted. A pose out of reach is
  /// not judged.
  [[nodiscard]] std::vector<Verdict> others(const ObservationSpace& space) const;
  /// times_sigma that chance reaches with probability `chance`.
  [[nodiscard]] double limit(double chance) const;

  [[nodiscard]] double sigma_mm() const { return sigma_mm_; }
  /// Residuals more than parameters that were fitted.
  [[nodiscard]] double freedom() const { return freedom_; }
  [[nodiscard]] const Structure& structure() const { return structure_; }

 private:
  /// W of one sample, W'W = its covariance^-1 times the mean variance of the fitted ones.
  [[nodiscard]] Eigen::MatrixXd whitening(const ObservationSpace& space, int sample) const;
  /// Columns of the structure for one sample, not whitened.
  [[nodiscard]] Eigen::MatrixXd structure_columns(const Eigen::RowVectorXd& shapes) const;

  int axes_ = 0;
  Eigen::Index measured_rows_ = 0;  // what is known of the instrument comes behind
  double mean_variance_mm2_ = 0.0;
  Structure structure_;
  std::optional<SmoothBasis> basis_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd to_determined_;  // parameters x determined directions
  Eigen::MatrixXd B_;
  Eigen::MatrixXd inverse_;  // (B'B + prior)^-1
  Eigen::VectorXd coefficient_;
  Eigen::VectorXd residual_;  // predicted - measured - B coefficient, by row
  double sigma_mm_ = 0.0, freedom_ = 0.0;
  double rough_ = 0.0;  // variance that is not as smooth as the structure, over sigma^2
};

}  // namespace sixdial::calibration
