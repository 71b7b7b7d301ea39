// Judges single dial readings by what all good ones predict of them: the fitted robot, and what
// neighbouring poses share that the model misses (as position_judge.h does for positions). What
// is smooth is no accident, however far it is from the model.
//
// A sample's own free rotation takes part of an error over: n is what is left of an error of 1
// mm at the reading, and the error is n'e / n'n with the variance of e along n.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/fit_covariance.h"
#include "calibration/least_squares.h"
#include "calibration/observation_space.h"

namespace sixdial::calibration {

class ReadingJudge {
 public:
  /// `space`: dial readings; `fit` minimised space.problem(Weighting::kBySigma).
  ReadingJudge(const ObservationSpace& space, const LeastSquaresFit& fit);

  /// Probability that noise alone makes a reading as large as it is. `of`: the space of its
  /// sample alone, the reading included, which was not fitted; `n`: of the reading, by row of
  /// `of`. Empty where the pose is out of reach or nothing can be seen.
  [[nodiscard]] std::optional<double> chance(
      const ObservationSpace& of, const Eigen::VectorXd& n) const;

  [[nodiscard]] const Eigen::VectorXd& x() const { return x_; }  // of the fit
  [[nodiscard]] const Structure& structure() const { return structure_; }

 private:
  /// d(row)/d(coefficient) of a sample's rows, weighted.
  [[nodiscard]] Eigen::MatrixXd columns(
      const ObservationSpace& space, int sample, const Eigen::MatrixXd& J,
      const Eigen::RowVectorXd& shapes) const;
  /// d(row)/d(function) of the structure, rows x functions, not weighted.
  [[nodiscard]] Eigen::MatrixXd moves(const ObservationSpace& space, int sample) const;
  [[nodiscard]] Eigen::VectorXd weights(const ObservationSpace& space, int sample) const;

  Structure structure_;
  std::optional<SmoothBasis> basis_;
  double mean_sigma_mm_ = 0.0;
  Eigen::VectorXd x_;
  Eigen::MatrixXd to_determined_;  // parameters x determined directions
  Eigen::MatrixXd inverse_;        // (B'B + prior)^-1
  Eigen::VectorXd coefficient_;
  double sigma_mm_ = 0.0, freedom_ = 0.0;
  double rough_ = 0.0;  // variance that is not as smooth as the structure, over sigma^2
};

}  // namespace sixdial::calibration
