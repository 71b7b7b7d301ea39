// What each sample of a session brings besides its joint values: its past, the hour, the
// temperature, the forces. Made from measured values and from where the plain simulation puts
// the cuboid, so that it does not move while parameters are fitted.
//
// - A direction is that of the last real move. A robot that stands still has not moved,
// whatever
//   its readings do: the sign of a difference of two readings at rest is the sign of the noise
//   that it would then explain. Where a plunger went is taken from the simulation, which has no
//   noise; it has moved if it went further than several standard deviations of its dial.
// - A missing value is missing: a temperature or a time is taken from its neighbours, with its
//   uncertainty; a reading that was lost while the face pushed the plunger in still is a force.
//   What nobody knows is 0, and `doubts` says what else it could have been.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simulation/effect.h"
#include "simulation/forward_model.h"

namespace sixdial::simulation {

/// Where it is known from which side a joint came.
enum class SidesFrom {
  kColumns,   // recorded with the samples
  kRows,      // not recorded: from the order of the samples, whose moves were direct
  kReversed,  // recorded with the other sign: nearly every move went the other way
};
/// By joint of the robot; `trials` in time order.
[[nodiscard]] std::vector<SidesFrom> sides_from(
    const geometry::RobotModel& robot, std::span<const Trial> trials);

/// Circumstances of a session's samples, in time order as given. `at` places the tool.
[[nodiscard]] std::vector<Circumstance> circumstances_of(
    const ForwardModel& model, const ModelVector& at, std::span<const Trial> trials);

/// Something about a sample that nobody knows: the circumstance with it changed by one standard
/// deviation.
struct Doubt {
  std::size_t trial = 0;
  Circumstance otherwise;
};
/// Of all samples, in their order. What is unknown of every sample (a column that the session
/// lacks) is left out: nothing can be said about it.
[[nodiscard]] std::vector<Doubt> doubts_of(std::span<const Circumstance> samples);

/// A value with its standard deviation.
struct Filled {
  double value = 0.0;
  double sd = 0.0;
};
/// A column with gaps: what is missing lies on the line between its neighbours, with the
/// variance that a value has which wanders as the known ones do; beyond the ends it stays as
/// the nearest. All 0 if nothing is known.
[[nodiscard]] std::vector<Filled> without_gaps(
    std::span<const double> along, std::span<const std::optional<double>> values);

}  // namespace sixdial::simulation
