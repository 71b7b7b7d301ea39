#include "calibration/reading_errors.h"

#include <algorithm>
#include <cmath>
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

void ReadingRange::add(double reading_mm) {
  const bool first = empty();
  low_mm = first ? reading_mm : std::min(low_mm, reading_mm);
  high_mm = first ? reading_mm : std::max(high_mm, reading_mm);
}

std::vector<ReadingRange> reading_ranges(
    std::span<const simulation::Trial> trials, std::size_t dials) {
  std::vector<ReadingRange> result(dials);
  for (const simulation::Trial& trial : trials) {
    for (std::size_t d = 0; d < dials && d < trial.reading.size(); ++d) {
      if (trial.reading[d]) result[d].add(*trial.reading[d]);
    }
  }
  return result;
}

Eigen::RowVectorXd curve_shapes(double reading_mm, const ReadingRange& range) {
  const double width = range.high_mm - range.low_mm;
  const double at =
      width > 0.0 ? std::clamp((reading_mm - range.low_mm) / width, 0.0, 1.0) : 0.0;
  // All waves alike; a cosine's square is a half on average.
  const double each = 1.0 / std::sqrt(1.0 + 0.5 * (kCurveShapes - 1));
  Eigen::RowVectorXd shapes(kCurveShapes);
  for (int wave = 0; wave < kCurveShapes; ++wave) {
    shapes[wave] = each * std::cos(std::numbers::pi * wave * at);
  }
  return shapes;
}

double curve_sd_mm(const geometry::Dial& dial) { return dial.accuracy_mm / std::sqrt(3.0); }

MatrixXd curve_columns(
    const ObservationSpace& space, std::span<const simulation::Trial> trials,
    const geometry::Rig& rig, const std::vector<MatrixXd>& by_readings,
    const std::vector<ReadingRange>& ranges) {
  MatrixXd columns =
      MatrixXd::Zero(space.rows(), kCurveShapes * static_cast<Index>(rig.dials.size()));
  std::size_t t = 0;
  for (int i = 0; i < space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    while (t < trials.size() && trials[t].sample != space.sample[k]) ++t;
    if (t == trials.size()) break;
    for (std::size_t d = 0; d < rig.dials.size() && d < trials[t].reading.size(); ++d) {
      if (!trials[t].reading[d]) continue;
      const auto at = static_cast<Index>(d);
      columns.block(space.first_row[k], kCurveShapes * at, space.rows(i), kCurveShapes) =
          by_readings[k].col(at) *
          (curve_sd_mm(rig.dials[d]) * curve_shapes(*trials[t].reading[d], ranges[d]));
    }
  }
  return columns;
}

}  // namespace sixdial::calibration
