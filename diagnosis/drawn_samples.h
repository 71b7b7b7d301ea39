// Of a very long session some samples are drawn, and only these are fitted and judged: what a
// cause does shows in thousands of readings as well as in a million, and time and memory grow
// with their number. All others are still the past of those that were drawn: from where a joint
// and a plunger came, and when.
//
// Drawn are whole poses, spread evenly over the session, and of many repeats at a pose a few.
// Which ones is left to chance, so that no period of the plan can hide between them.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/trial.h"

namespace sixdial::diagnosis {

/// By trial: whether it is drawn; about `most` of them, as many of the held-out ones as their
/// share. All where there are no more, or where `most` is 0. The same for the same seed.
[[nodiscard]] std::vector<bool> drawn_samples(
    const std::vector<simulation::Trial>& trials, const std::vector<bool>& held_out,
    std::size_t most, std::uint64_t seed);

}  // namespace sixdial::diagnosis
