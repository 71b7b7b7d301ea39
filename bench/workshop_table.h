// The table of what is asked of rigs as they are, with what was reached (blind_challenge
// --workshop).
#pragma once

#include <cstdint>

#include "tests/blind/workshop.h"

namespace sixdial::blind {

/// Over `sessions` drawn rigs; `verbose` prints each session.
void print_workshop(
    int sessions, std::uint64_t first_seed, int threads, const WorkshopCase& of, bool verbose);

}  // namespace sixdial::blind
