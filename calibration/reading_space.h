// The observation space of any instrument by its channels: pose, distance, probe, socket,
// positions of several points. Parameters: the robot's, then the instrument's. Each thing that
// is known of the instrument itself (a place to within its deviation, the distance of two
// sockets) is one extra sample after the measured ones; its joint values are the mean of
// theirs, so that it is no pose of its own. A sample's error of position is the least shift of
// the tool that explains what was read. An angle counts as what it moves at the end of a lever
// (geometry/lever.h): all rows are lengths. Those of poses weigh alike, as those of positions.
//
//   const ObservationSpace space = reading_space(session::trials_of(session, "G1"), rig);
//   const SpaceFit fit = fit_space(space, {.weighting = Weighting::kBySigma});
#pragma once

#include <span>

#include "calibration/observation_space.h"
#include "geometry/instrument_kind.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// `noise_mm`: sigma of a row where the rig file does not say how good a reading is. Parameters
/// of the instrument that nobody knows start at a closed-form estimate from the samples and the
/// nominal robot.
[[nodiscard]] ObservationSpace reading_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    double noise_mm = 0.003);

/// Whether a rig's instrument gives positions of the tool, or its dials allow them.
[[nodiscard]] bool gives_positions(const geometry::Rig& rig);

/// What a robot is fitted to and judged by: positions (rig_spaces.h), or the readings of an
/// instrument that gives none.
[[nodiscard]] ObservationSpace measured_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    double noise_mm = 0.003);

/// Whether a rig's instrument measures how its tool is turned, and parameters of its robot
/// follow that.
[[nodiscard]] bool fits_turns(const geometry::Rig& rig);
/// Whether a turn of the tool was measured in this trial.
[[nodiscard]] bool has_turn(
    const simulation::Trial& trial, const geometry::InstrumentModel& instrument);
/// fits_turns(rig), and at least one of these trials has_turn.
[[nodiscard]] bool fits_turns(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

/// What a robot's parameters are found from: measured_space, and with the turns where the
/// rig and the trials allow it (fits_turns).
[[nodiscard]] ObservationSpace fitted_space(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    double noise_mm = 0.003);

/// Whether the first channels of a space are the tool's coordinates.
[[nodiscard]] bool shows_position(const ObservationSpace& space);

/// Samples of `space` that were measured: all but the extra ones at its end. position_errors
/// has a column for each of these.
[[nodiscard]] int measured_samples(const ObservationSpace& space);

}  // namespace sixdial::calibration
