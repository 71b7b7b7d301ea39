// What the rig's own geometry does to a fit of the robot: a dial that stands 0.1 mm beside
// where the rig file says puts every position off by the same law, so that no number of points
// averages it out (spec 8). What the file states with a standard deviation enters the
// covariance here. A diagnosis fits these quantities together with the robot
// (diagnosis/rig_columns.h).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/observation_space.h"
#include "calibration/sandwich.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// Change of each row [mm] where a quantity that the rig file states with a standard deviation
/// is off by that: rows x quantities. A position is computed from three dials, so it moves by
/// the inverse of their Jacobian. 0 x 0 where nothing is stated or the rig has no dials.
/// `trials`: those that the space was made of, in its order.
[[nodiscard]] Eigen::MatrixXd rig_errors(
    const ObservationSpace& space, std::span<const simulation::Trial> trials,
    const geometry::Rig& rig);

/// d(rows)/d(readings) of each sample, its rows x the rig's dials: a position moves as its
/// three active dials take it. Zero where an instrument gave the rows. `trials`: as above.
[[nodiscard]] std::vector<Eigen::MatrixXd> by_readings(
    const ObservationSpace& space, std::span<const simulation::Trial> trials,
    const geometry::Rig& rig);

/// How far each quantity moves the fitted parameters, parameters x quantities; no columns where
/// space.rig_mm has none.
[[nodiscard]] Eigen::MatrixXd moved_by_rig(
    const ObservationSpace& space, const Sandwich& sandwich);
/// The same as a covariance, parameters x parameters. `fit` minimised
/// space.problem(weighting).
[[nodiscard]] Eigen::MatrixXd rig_covariance(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting);

}  // namespace sixdial::calibration
