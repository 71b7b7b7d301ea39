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

#include "calibration/identifiability.h"
#include "calibration/identifier.h"
#include "geometry/tool.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// Two-sided 95 % of the normal distribution: the interval is +- this many sd.
inline constexpr double kNormal_95 = 1.959963984540054;
/// Repeats tell the noise with at least so many degrees of freedom (to a fifth, one sigma).
inline constexpr int kEnoughRepeats = 10;

enum class NoiseSource { kRepeats, kResidual, kRigFile };
/// "repeats", "residual", "rig_file".
[[nodiscard]] std::string_view to_string(NoiseSource source);

/// Standard deviation of one reading (one axis of a position, or one dial).
struct NoiseEstimate {
  NoiseSource source = NoiseSource::kRigFile;
  double sigma_mm = 0.0;
  int degrees_of_freedom = 0;  // 0: taken as known (rig file)
  // The three as far as the session has them.
  std::optional<RepeatNoise> repeats;
  std::optional<RepeatNoise> residual;
  double rig_file_mm = 0.0;
  /// How many times larger the residual is than the noise of the repeats, if that is more than
  /// chance allows (95 %): the model then misses something, and the uncertainties cover the
  /// noise alone.
  std::optional<double> lack_of_fit;
  std::string words;  // which, why, and the warning
};

/// Repeats if there are enough, else the residual of the fit, else the space's own sigma (from
/// the rig file).
[[nodiscard]] NoiseEstimate noise_estimate(
    const ObservationSpace& space, const LeastSquaresFit& fit);

/// 95 % quantile for an estimate's degrees of freedom; 1.96 where the noise is taken as known.
[[nodiscard]] double quantile_95(const NoiseEstimate& noise);

/// All parameters with the intervals that this noise gives. Each parameter's covariance comes
/// back in `covariance`, n x n.
[[nodiscard]] std::vector<ParameterEstimate> estimates_with_noise(
    const ObservationSpace& space, const LeastSquaresFit& fit, const NoiseEstimate& noise,
    Eigen::MatrixXd& covariance);

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
/// `quantile`: quantile_95. The tool has an inverse.
[[nodiscard]] PositionUncertainty position_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& covariance,
    const LeastSquaresFit& fit, geometry::WorkingMode mode, const Workspace& workspace,
    double quantile, int columns = 13, int rows = 19);

}  // namespace sixdial::calibration
