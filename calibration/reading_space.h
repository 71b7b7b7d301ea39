// The observation space of any instrument by its channels: pose, distance, probe, socket,
// positions of several points. Parameters: the robot's, then the instrument's. What is known of
// the instrument's own (a place to within its deviation, the distance of two sockets) is one
// more sample each, which no joint values belong to.
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
/// angle it is that over the robot's size. Parameters that nobody knows start where the samples
/// put them by the nominal robot.
[[nodiscard]] ObservationSpace reading_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    double noise_mm = 0.003);

/// Samples of `space` that are measured: without those that say what is known.
[[nodiscard]] int measured_samples(const ObservationSpace& space);

}  // namespace sixdial::calibration
