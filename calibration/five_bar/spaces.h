// The five-bar's observation spaces: its tool positions, or the raw readings of all dials on
// its cuboid. The only place above geometry/ where a method's numbers turn into this robot's;
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

/// Raw readings of all dials in contact: with the clamp angle as an eleventh parameter, or with
/// the cuboid's rotation eliminated sample by sample where it is held freely. Trials with fewer
/// readings than 2 (mounted) or 3 (free) are left out.
[[nodiscard]] ObservationSpace dial_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

/// Noise from the repeats among all trials, also those that no space would use: of dial
/// readings, or of positions. Empty without repeats.
[[nodiscard]] std::optional<RepeatNoise> repeat_noise(
    std::span<const simulation::Trial> trials, bool dials);

/// The ten parameters' names, in the order of geometry::kParameters.
[[nodiscard]] std::vector<std::string_view> parameter_names();
/// Parameter changes of one unit each: 1 mm of a length, and the angle that moves a link's end
/// by about as much (1/60 rad). Directions of parameter space are measured in these.
[[nodiscard]] geometry::ParameterVector parameter_scale();

}  // namespace sixdial::calibration
