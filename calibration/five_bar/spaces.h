// The five-bar's observation spaces: its tool positions, or the raw readings of all dials on
// its cuboid. rig_spaces.h makes those of any robot and asks for these where they are faster;
// the vector kernels behind it are position_kernel.h and swarm_kernels.h.
//
//   const ObservationSpace space = position_space(position_observations(trials), nominal);
//   const double before_mm = position_rmse(space, space.nominal);
#pragma once

#include <span>

#include "calibration/five_bar/positions.h"
#include "calibration/observation_space.h"
#include "geometry/rig.h"

namespace sixdial::calibration {

/// x and y of each sample, ten parameters. `noise_mm`: sigma of an axis where the observations
/// carry no covariance.
[[nodiscard]] ObservationSpace position_space(
    PositionObservations observations, const geometry::ParameterVector& nominal,
    double noise_mm = 0.003);

/// The spaces of a five-bar rig, as position_space and dial_space of rig_spaces.h.
[[nodiscard]] ObservationSpace five_bar_position_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig, double noise_mm);
[[nodiscard]] ObservationSpace five_bar_dial_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

/// The ten parameters' names, in the order of geometry::kParameters.
[[nodiscard]] std::vector<std::string_view> parameter_names();
/// Parameter changes of one unit each: 1 mm of a length, and the angle that moves a link's end
/// by about as much (1/60 rad). Directions of parameter space are measured in these.
[[nodiscard]] geometry::ParameterVector parameter_scale();

}  // namespace sixdial::calibration
