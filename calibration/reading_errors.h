// What errors of single dial readings do to a fit: independent ones, which many readings
// average out, and a dial's own error curve, which they do not.
//
//   const auto by = by_readings(space, trials, rig);
//   const Eigen::MatrixXd C = scatter_covariance(sandwich, by, sd_mm);
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/observation_space.h"
#include "calibration/sandwich.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// Covariance of the fitted parameters where every reading is off by itself, with the standard
/// deviation `sd_mm` of its dial. `by_readings`: of the space (rig_errors.h).
[[nodiscard]] Eigen::MatrixXd scatter_covariance(
    const Sandwich& sandwich, const std::vector<Eigen::MatrixXd>& by_readings,
    const Eigen::VectorXd& sd_mm);

/// What a dial read, from the least to the most; empty: nothing.
struct ReadingRange {
  double low_mm = 0.0, high_mm = -1.0;
  [[nodiscard]] bool empty() const { return high_mm < low_mm; }
  void add(double reading_mm);
};
/// Of each dial.
[[nodiscard]] std::vector<ReadingRange> reading_ranges(
    std::span<const simulation::Trial> trials, std::size_t dials);

/// An error curve of a dial is a few shapes of its own reading: a constant and four cosines, as
/// a curve bends a few times over what was read.
inline constexpr int kCurveShapes = 5;
/// Of one dial at one reading: values whose squares add up to a mean of 1. Outside of the range
/// as at its end.
[[nodiscard]] Eigen::RowVectorXd curve_shapes(double reading_mm, const ReadingRange& range);
/// A maker's limit of +-a means this standard deviation of a curve (a / sqrt(3), GUM 4.3.7).
[[nodiscard]] double curve_sd_mm(const geometry::Dial& dial);

/// Change of each row [mm] for each shape of each dial's curve, all of the standard deviation
/// that the dial's limit means: rows x (dials x kCurveShapes). `by_readings`: of the space.
[[nodiscard]] Eigen::MatrixXd curve_columns(
    const ObservationSpace& space, std::span<const simulation::Trial> trials,
    const geometry::Rig& rig, const std::vector<Eigen::MatrixXd>& by_readings,
    const std::vector<ReadingRange>& ranges);

}  // namespace sixdial::calibration
