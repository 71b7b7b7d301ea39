// The observation spaces of a rig: its tool positions, or the raw readings of all dials on its
// cuboid, for any kind of robot. A kind may have faster ones of its own (five_bar/spaces.h).
//
//   const ObservationSpace space = position_space(session::trials_of(session, "G1"), rig);
//   const double before_mm = position_rmse(space, space.nominal);
#pragma once

#include <optional>
#include <span>

#include "calibration/observation_space.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// The positions of trials, in the coordinates that the rig measures; trials without one are
/// left out. Parameters: the robot's. `noise_mm`: sigma of an axis where a trial carries no
/// covariance.
[[nodiscard]] ObservationSpace position_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    double noise_mm = 0.003);

/// Raw readings of all dials in contact: with the clamp angle as one more parameter, or with
/// the cuboid's rotation eliminated sample by sample where it is held freely. Trials with fewer
/// readings than 2 (mounted) or 3 (free) are left out; without dials there are no samples.
[[nodiscard]] ObservationSpace dial_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

}  // namespace sixdial::calibration
