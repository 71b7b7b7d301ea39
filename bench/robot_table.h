// The table of the blind challenge on robots in space.
#pragma once

#include <cstdint>

#include "tests/blind/robot_outcome.h"

namespace sixdial::blind {

using Challenged = RobotOutcome (*)(const RobotChallenge& of, std::uint64_t seed);

/// `sessions` of each line; prints as it goes. Number of figures that were not reached.
int print_robots(
    const char* title, Challenged challenged, int sessions, std::uint64_t first_seed,
    int threads, bool verbose);

}  // namespace sixdial::blind
