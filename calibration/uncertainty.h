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
#include "geometry/tool.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// All parameters with their 95 % intervals: the noise, and the structure that neighbouring
/// poses share in the residuals (none: the default). Standard deviation and interval are NaN
/// where too few readings are left to know them (NoiseEstimate::known). `fit` minimised
/// space.problem(weighting). Each parameter's covariance comes back in `covariance`, n x n.
[[nodiscard]] std::vector<ParameterEstimate> estimates_with_noise(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    const NoiseEstimate& noise, const Structure& structure, Eigen::MatrixXd& covariance);

/// What is held at nominal is no better known than before any sample: the covariance that the
/// held directions keep, n x n; zero if nothing is held. `infos`: of all fitted parameters.
[[nodiscard]] Eigen::MatrixXd held_covariance(
    const LeastSquaresFit& fit, std::span<const geometry::ParameterInfo> infos);

struct Workspace {
  geometry::Position low_mm, high_mm;  // in W
};
/// The rectangle (in space: the box) around measured positions (targets where there are none).
[[nodiscard]] std::optional<Workspace> workspace_of(std::span<const simulation::Trial> trials);

/// Uncertainty of f(v) on a grid over the workspace, row by row from low y; in space halfway up
/// its height. NaN where the robot cannot go.
struct PositionUncertainty {
  int columns = 0, rows = 0;
  std::vector<double> x_mm, y_mm;            // of columns, of rows
  std::vector<Eigen::VectorXd> sd_mm;        // of each coordinate
  std::vector<double> radius_95_mm;          // of a circle or sphere that holds it
  double mean_sd_mm = 0.0, max_sd_mm = 0.0;  // of the distance, root of the trace
  double max_radius_95_mm = 0.0;
  geometry::Position worst_mm;
  /// For each held direction: how far the tool's position moves at most [mm] if the true robot
  /// is one unit (1 mm, 1/60 rad) away from nominal along it. Small: holding the direction does
  /// no harm here.
  std::vector<double> held_effect_mm;
  [[nodiscard]] double sd(int column, int row) const {
    return sd_mm[static_cast<std::size_t>(row * columns + column)].norm();
  }
};

/// `v`: the robot's parameters; `covariance`: of all that were fitted, the robot's first.
/// `quantile`: quantile_95. `structure_mm`: what the model misses at one place, in each axis
/// (Structure::sd_mm). The tool has an inverse.
[[nodiscard]] PositionUncertainty position_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& covariance,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, double structure_mm = 0.0, int columns = 13, int rows = 19);

}  // namespace sixdial::calibration
