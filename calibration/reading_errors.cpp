#include "calibration/reading_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sixdial::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd scatter_covariance(
    const Sandwich& sandwich, const std::vector<MatrixXd>& by_readings, const VectorXd& sd_mm) {
  MatrixXd result = MatrixXd::Zero(sandwich.noise.rows(), sandwich.noise.cols());
  for (std::size_t i = 0; i < by_readings.size(); ++i) {
    const MatrixXd moved = sandwich.AW[i] * by_readings[i] * sd_mm.asDiagonal();
    result += moved * moved.transpose();
  }
  return result;
}

MatrixXd curve_shapes(
    const ObservationSpace& space, std::span<const simulation::Trial> trials, int dial) {
  constexpr int kWaves = 5;
  const auto k = static_cast<std::size_t>(dial);
  VectorXd reading =
      VectorXd::Constant(space.samples(), std::numeric_limits<double>::quiet_NaN());
  std::size_t t = 0;
  for (int i = 0; i < space.samples(); ++i) {
    while (t < trials.size() && trials[t].sample != space.sample[static_cast<std::size_t>(i)]) {
      ++t;
    }
    if (t == trials.size()) break;
    if (k < trials[t].reading.size()) reading[i] = trials[t].reading[k].value_or(reading[i]);
  }
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double each : reading) {
    if (!std::isfinite(each)) continue;
    low = std::min(low, each);
    high = std::max(high, each);
  }
  // All waves alike; a cosine's square is a half on average.
  const double each_mm = 1.0 / std::sqrt(1.0 + 0.5 * (kWaves - 1));
  MatrixXd shapes = MatrixXd::Zero(space.samples(), kWaves);
  for (Index i = 0; i < reading.size(); ++i) {
    if (!std::isfinite(reading[i])) continue;
    const double at = high > low ? (reading[i] - low) / (high - low) : 0.0;
    for (int wave = 0; wave < kWaves; ++wave) {
      shapes(i, wave) = each_mm * std::cos(std::numbers::pi * wave * at);
    }
  }
  return shapes;
}

MatrixXd moved_by_curve(
    const Sandwich& sandwich, const std::vector<MatrixXd>& by_readings, int dial,
    const MatrixXd& shapes) {
  MatrixXd moved = MatrixXd::Zero(sandwich.noise.rows(), shapes.cols());
  for (std::size_t i = 0; i < by_readings.size(); ++i) {
    moved += sandwich.AW[i] * by_readings[i].col(dial) * shapes.row(static_cast<Index>(i));
  }
  return moved;
}

}  // namespace sixdial::calibration
