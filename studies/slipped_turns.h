// Turns of the tool that slipped by little: a target that was lost and found again, a frame of
// another moment. Against the nominal robot they cannot be told from a robot that is different
// (plausibility/tool_turn.cpp sees degrees only); against the robot that all other turns agree
// on they stand out by hundreds of standard deviations, and in a fit of squares they would bend
// it.
//
//   session::Session used = session;
//   if (const auto slipped = leave_out_slipped_turns(used, trials, {})) show(slipped->code);
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "calibration/identifier.h"
#include "session/session.h"
#include "simulation/trial.h"
#include "studies/plausibility.h"

namespace sixdial::studies {

/// Fewer turns than these do not tell how the tool's frame sits.
inline constexpr int kFewestTurns = 4;

/// Whether so many of `turns` that are far off may be accidents, and be left out: one, or up to
/// 15 % of them, and enough stay. More are a fault of the measurement, and nobody knows which
/// part of them is right.
[[nodiscard]] bool may_be_accidents(std::ptrdiff_t far, std::ptrdiff_t turns);

/// Takes the turns that slipped out of `session`, positions of the same samples stay. `g1`: its
/// trials that are fitted. Empty: there are none, or its rig fits no turns. Turns that are too
/// many to be accidents stay, and the warning is a doubt.
[[nodiscard]] std::optional<Warning> leave_out_slipped_turns(
    session::Session& session, std::span<const simulation::Trial> g1,
    const calibration::IdentifySettings& settings);

}  // namespace sixdial::studies
