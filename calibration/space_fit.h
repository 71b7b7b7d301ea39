// The parameters by Levenberg-Marquardt on all samples of a space: the minimum that equations
// (29) and (31) can reach, with what the data say about each parameter.
//
//   const SpaceFit fit = fit_space(space, {.noise_mm = 0.003});
//   const double sd = std::sqrt(fit.covariance(0, 0));
#pragma once

#include <optional>
#include <vector>

#include "calibration/least_squares.h"
#include "calibration/observation_space.h"

namespace sixdial::calibration {

struct SpaceFitSettings {
  std::optional<Eigen::VectorXd> start;     // default: nominal
  std::vector<char> fixed;                  // 1: keeps its nominal value; empty: all free
  Weighting weighting = Weighting::kAlike;  // default: every row alike, as (31)
  Loss loss = Loss::kSquare;
  /// Residuals larger than about this count less; 0: 2.5 robust standard deviations of the
  /// residuals themselves.
  double loss_scale_mm = 0.0;
  /// Standard deviation of one reading, to judge what can be determined.
  double noise_mm = 0.003;
  /// A direction in the parameters that the data leave more uncertain than this is held at
  /// nominal [in units of ParameterInfo::change]: a robot is built more accurately than that.
  double hold_uncertainty_mm = 2.0;
};

struct SpaceFit {
  Eigen::VectorXd v;
  double rmse_mm = 0.0;
  double sigma_mm = 0.0;  // of one reading, from the residuals; 0 without degrees of freedom
  Eigen::MatrixXd covariance;
  LeastSquaresFit fit;
};

[[nodiscard]] SpaceFit fit_space(
    const ObservationSpace& space, const SpaceFitSettings& settings = {});

/// What the data say at given parameters, without fitting: Jacobian, singular values,
/// covariance.
[[nodiscard]] SpaceFit assess_space(
    const ObservationSpace& space, const Eigen::VectorXd& v,
    const SpaceFitSettings& settings = {});

}  // namespace sixdial::calibration
