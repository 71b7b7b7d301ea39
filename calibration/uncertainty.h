// What a fit's numbers are worth: which noise they rest on, standard deviation and 95 %
// interval of each parameter, and of the position that the robot is predicted to take anywhere
// in its workspace.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/fit_covariance.h"
#include "calibration/identifiability.h"
#include "calibration/identifier.h"
#include "calibration/noise.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// All parameters with their 95 % intervals: the noise, and the structure that neighbouring
/// poses share in the residuals (none: the default). Standard deviation and interval are NaN
/// where too few readings are left to know them (NoiseEstimate::known). `fit` minimised
/// space.problem(weighting). Each parameter's covariance comes back in `covariance`, n x n.
[[nodiscard]] std::vector<ParameterEstimate> estimates_with_noise(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    const NoiseEstimate& noise, const Structure& structure, Eigen::MatrixXd& covariance);

struct Workspace {
  Eigen::Vector2d low_mm, high_mm;  // in W
};
/// The rectangle around measured positions (targets where there are none).
[[nodiscard]] std::optional<Workspace> workspace_of(std::span<const simulation::Trial> trials);

/// Uncertainty of f(v) on a grid over the workspace, row by row from low y. NaN where the robot
/// cannot go.
struct PositionUncertainty {
  int columns = 0, rows = 0;
  std::vector<double> x_mm, y_mm;            // of columns, of rows
  std::vector<Eigen::Vector2d> sd_mm;        // of x and of y
  std::vector<double> radius_95_mm;          // of a circle that holds it
  double mean_sd_mm = 0.0, max_sd_mm = 0.0;  // of the distance, root of the trace
  double max_radius_95_mm = 0.0;
  Eigen::Vector2d worst_mm{0, 0};
  /// How far the position moves at most, for each held direction, if the robot is one unit (1
  /// mm, 1/60 rad) from nominal along it [mm]. Small: holding it costs nothing here.
  std::vector<double> held_effect_mm;
  [[nodiscard]] double sd(int column, int row) const {
    return sd_mm[static_cast<std::size_t>(row * columns + column)].norm();
  }
};

/// `covariance`: of the parameters, of which the first ten count. `quantile`: quantile_95.
/// `structure_mm`: what the model misses at one place, in each axis (Structure::sd_mm).
[[nodiscard]] PositionUncertainty position_uncertainty(
    const geometry::ParameterVector& v, const Eigen::MatrixXd& covariance,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, double structure_mm = 0.0, int columns = 13, int rows = 19);

}  // namespace sixdial::calibration
