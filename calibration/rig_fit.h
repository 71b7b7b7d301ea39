// The rig as the readings see it: what the file states with a standard deviation (places and
// axes of the dials, tips, cuboid) is fitted along with the robot to all raw readings, each
// with what was known of it before; beside it the dials' own error curves within their limits
// (spec 8). The positions that are then computed from the readings are those of the rig as it
// stands.
//
//   if (const auto seen = fit_rig(trials, rig)) positions_of(seen->rig);
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "calibration/least_squares.h"
#include "geometry/rig.h"
#include "simulation/rig_quantities.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

struct RigFit {
  geometry::Rig rig;  // the dials where they were found; deviations as the file states them
  std::vector<simulation::RigQuantity> quantities;
  Eigen::VectorXd off;         // of each, from the file, in standard deviations
  Eigen::MatrixXd covariance;  // of that: 1 on the diagonal where the readings say nothing
  double sigma_mm = 0.0;       // of one reading, by what the fit leaves
  /// Columns of ObservationSpace::rig_mm for one prior standard deviation each, times this, are
  /// independent of each other and of size 1: what is left to be known. What `rig` cannot carry
  /// (the cuboid's squareness and centre) counts with what it is off by.
  [[nodiscard]] Eigen::MatrixXd left_open() const;
};

/// Empty where the file states nothing, or too few readings are there to fit a robot. `fixed`:
/// of the robot's parameters. `loss`: kHuber while nobody has looked for gross errors. Of many
/// trials a spread part is taken.
[[nodiscard]] std::optional<RigFit> fit_rig(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    const std::vector<char>& fixed = {}, Loss loss = Loss::kSquare);

/// The rig of the file with each stated quantity off by so many of its standard deviations:
/// dials and side of the cuboid, as far as a rig has them. `off`: of stated_quantities(rig).
[[nodiscard]] geometry::Rig moved_rig(const geometry::Rig& rig, const Eigen::VectorXd& off);

}  // namespace sixdial::calibration
