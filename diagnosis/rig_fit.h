// The rig as the readings see it, before anybody asks for causes: robot, what the rig file
// states with a standard deviation (places and axes of the dials, tips, cuboid), the dials'
// error curves within their makers' limits, and whatever else is smooth, all fitted together to
// the raw readings (joint_fit.h). What is smooth takes its share of the readings, or it would
// be mistaken for a place. Gross readings have no say.
//
//   if (const auto seen = fit_rig(trials, rig)) positions_by(seen->rig);
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "calibration/reading_errors.h"
#include "geometry/rig.h"
#include "simulation/rig_quantities.h"
#include "simulation/trial.h"

namespace sixdial::diagnosis {

struct RigFit {
  geometry::Rig rig;  // the dials where they were found; deviations as the file states them
  std::vector<simulation::RigQuantity> quantities;
  Eigen::VectorXd off;         // of each, from the file, in standard deviations
  Eigen::MatrixXd covariance;  // of that: 1 on the diagonal where the readings say nothing
  std::vector<calibration::ReadingRange> ranges;  // of each dial: what its curve runs over
  /// What `rig` leaves to be known: second moments of the quantities, then of the shapes of
  /// each dial's curve (calibration::curve_columns), in the standard deviations known before.
  /// Curves, and the cuboid's squareness and centre, are not in `rig`: they count with what
  /// they were found to be.
  Eigen::MatrixXd open;
};

/// Empty where the file states nothing, where there are not more readings than unknowns of the
/// robot, or where the fit does not settle. Of many trials a part is drawn.
[[nodiscard]] std::optional<RigFit> fit_rig(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

}  // namespace sixdial::diagnosis
