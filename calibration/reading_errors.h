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
#include "simulation/trial.h"

namespace sixdial::calibration {

/// Covariance of the fitted parameters where every reading is off by itself, with the standard
/// deviation `sd_mm` of its dial. `by_readings`: of the space (rig_errors.h).
[[nodiscard]] Eigen::MatrixXd scatter_covariance(
    const Sandwich& sandwich, const std::vector<Eigen::MatrixXd>& by_readings,
    const Eigen::VectorXd& sd_mm);

/// An error curve of a dial as a few shapes of its own reading, samples x shapes: the products
/// of two rows add up to a mean variance of 1. A constant and four cosines: a curve bends a few
/// times over the range that was read. 0 where the dial has no reading.
[[nodiscard]] Eigen::MatrixXd curve_shapes(
    const ObservationSpace& space, std::span<const simulation::Trial> trials, int dial);

/// How far the shapes of that dial's curve, each 1 mm large, move the fitted parameters,
/// parameters x shapes.
[[nodiscard]] Eigen::MatrixXd moved_by_curve(
    const Sandwich& sandwich, const std::vector<Eigen::MatrixXd>& by_readings, int dial,
    const Eigen::MatrixXd& shapes);

}  // namespace sixdial::calibration
