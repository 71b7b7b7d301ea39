// The observation space of any instrument by its channels: pose, distance, probe, socket,
// positions of several points. Parameters: the robot's, then the instrument's. Each thing that
// is known of the instrument itself (a place to within its deviation, the distance of two
// sockets) is one extra sample after the measured ones; it has no joint values.
//
//   const ObservationSpace space = reading_space(session::trials_of(session, "G1"), rig);
//   const SpaceFit fit = fit_space(space, {.weighting = Weighting::kBySigma});
#pragma once

#include <span>

#include "calibration/observation_space.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// `noise_mm`: sigma of a length where the rig file does not say how good a reading is; of an
/// angle it is that over half a metre. Parameters of the instrument that nobody knows start at
/// a closed-form estimate from the samples and the nominal robot.
[[nodiscard]] ObservationSpace reading_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    double noise_mm = 0.003);

/// Samples of `space` that were measured: all but the extra ones at its end.
[[nodiscard]] int measured_samples(const ObservationSpace& space);

}  // namespace sixdial::calibration
