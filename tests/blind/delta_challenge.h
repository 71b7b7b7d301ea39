// Blind challenges on deltas: a drawn one on towers or with arms, under a tracker or draw
// wires, what is wrong with it hidden, the session written as files, read back and diagnosed as
// a user would.
#pragma once

#include <cstdint>

#include "tests/blind/robot_outcome.h"

namespace sixdial::blind {

[[nodiscard]] RobotOutcome challenge_delta(const RobotChallenge& of, std::uint64_t seed);

}  // namespace sixdial::blind
