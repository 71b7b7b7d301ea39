// One calibration problem as every identifier sees it: samples with rows of measured values
// that a parameter vector x predicts. Two spaces: positions (x and y of each sample, ten
// parameters) and dials (raw displacements of all dials in contact, with the clamp angle as an
// eleventh parameter, or with the cuboid's rotation eliminated sample by sample where it is
// held freely).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "calibration/least_squares.h"
#include "calibration/observations.h"
#include "geometry/rig.h"

namespace sixdial::calibration {

struct ObservationSpace {
  std::string_view name;                          // "positions", "dials"
  std::vector<std::string_view> parameter_names;  // n; the first ten as geometry::kParameters
  Eigen::VectorXd nominal;                        // n
  Eigen::VectorXd scale;                          // n: changes of about one millimetre
  std::vector<int> first_row;                     // samples + 1: rows of sample i start at [i]
  std::vector<int> channel;                       // by row: 0 x and 1 y, or the dial's index
  int channels = 2;
  Eigen::VectorXd sigma_mm;  // by row: standard deviation of the reading
  std::vector<int> sample;   // row of the session, by sample
  /// e = measured - predicted [mm] of one sample and, unless null, J = d(predicted)/dx (rows x
  /// n). Both come in with the right size. False if x cannot reach the pose.
  std::function<bool(
      int sample, const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> e, Eigen::MatrixXd* J)>
      evaluate;
  /// The same samples as positions, where this is that space: fast kernels exist for it.
  std::shared_ptr<const PositionObservations> positions;

  [[nodiscard]] int parameters() const { return static_cast<int>(nominal.size()); }
  [[nodiscard]] int samples() const { return static_cast<int>(first_row.size()) - 1; }
  [[nodiscard]] int rows() const { return first_row.back(); }
  /// Rows of one sample.
  [[nodiscard]] int rows(int of_sample) const {
    const auto i = static_cast<std::size_t>(of_sample);
    return first_row[i + 1] - first_row[i];
  }
  /// Residuals predicted - measured of all rows; `weighted`: each times mean sigma / its sigma,
  /// so that they stay in mm.
  [[nodiscard]] LeastSquaresProblem problem(bool weighted) const;
  /// Root of the mean over samples of the squared error length, unweighted [mm]; +inf if a pose
  /// cannot be reached.
  [[nodiscard]] double rmse(const Eigen::VectorXd& x) const;
  /// Mean of sigma_mm squared, as a standard deviation.
  [[nodiscard]] double mean_sigma() const;
  /// Index of a parameter by name.
  [[nodiscard]] std::optional<int> find(std::string_view parameter) const;
};

/// `noise_mm`: sigma of an axis where the observations carry no covariance.
[[nodiscard]] ObservationSpace position_space(
    PositionObservations observations, const geometry::ParameterVector& nominal,
    double noise_mm = 0.003);

/// Raw readings of all dials in contact. Trials with fewer readings than 2 (mounted) or 3
/// (free) are left out.
[[nodiscard]] ObservationSpace dial_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

/// Which parameters keep their nominal value, from names such as "d" or "alpha". The error is
/// the name that no parameter has.
[[nodiscard]] tl::expected<std::vector<char>, std::string> fixed_by_name(
    const ObservationSpace& space, std::span<const std::string> names);

}  // namespace sixdial::calibration
