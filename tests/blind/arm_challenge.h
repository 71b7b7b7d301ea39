// Blind challenges on robot arms: a drawn arm under a drawn instrument, what is wrong with it
// hidden, the session written as files, read back and diagnosed as a user would.
#pragma once

#include <cstdint>

#include "tests/blind/robot_outcome.h"

namespace sixdial::blind {

[[nodiscard]] RobotOutcome challenge_arm(const RobotChallenge& of, std::uint64_t seed);

}  // namespace sixdial::blind
