// The ten parameters by Levenberg-Marquardt on measured positions: the minimum that equations
// (29) and (31) can reach, with what the data say about each parameter.
#pragma once

#include <array>
#include <optional>

#include "calibration/least_squares.h"
#include "calibration/observations.h"

namespace sixdial::calibration {

/// Parameter changes of one unit each: 1 mm of a length, and the angle that moves a link's end
/// by about as much (1/60 rad). Directions of parameter space are measured in these.
[[nodiscard]] geometry::ParameterVector parameter_scale();

using FixedParameters = std::array<bool, geometry::kParameterCount>;

struct PositionFitSettings {
  std::optional<geometry::ParameterVector> start;  // default: nominal
  FixedParameters fixed{};                         // keep their nominal value
  bool weigh_by_covariance = false;  // default: every position counts alike, as (31)
  Loss loss = Loss::kSquare;
  /// Residuals larger than about this count less; 0: 2.5 robust standard deviations of the
  /// residuals themselves.
  double loss_scale_mm = 0.0;
  /// Standard deviation of one measured axis, to judge what can be determined.
  double noise_mm = 0.003;
  /// A direction whose standard deviation would be larger than this is held at nominal [mm or
  /// 1/60 rad]: manufacture is better than that.
  double hold_uncertainty_mm = 2.0;
};

struct PositionFit {
  geometry::ParameterVector v;
  double rmse_mm = 0.0;
  double sigma_mm = 0.0;  // of one axis, from the residuals; 0 without degrees of freedom
  geometry::ParameterMatrix covariance = geometry::ParameterMatrix::Zero();
  LeastSquaresFit fit;
};

[[nodiscard]] PositionFit fit_positions(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const PositionFitSettings& settings = {});

/// What the data say at given parameters, without fitting: Jacobian, singular values,
/// covariance.
[[nodiscard]] PositionFit assess_positions(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const geometry::ParameterVector& v, const PositionFitSettings& settings = {});

/// Residuals f(v) - measured of all positions, x before y, and their Jacobian.
[[nodiscard]] LeastSquaresProblem position_problem(
    const PositionObservations& observations, bool weigh_by_covariance = false);

}  // namespace sixdial::calibration
