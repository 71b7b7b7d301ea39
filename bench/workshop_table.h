// The table of what is asked of rigs as they are, with what was reached (blind_challenge
// --workshop).
#pragma once

#include <cstdint>
#include <vector>

#include "tests/blind/workshop.h"

namespace sixdial::blind {

/// What many sessions say together.
struct WorkshopSum {
  int n = 0, wrong = 0, strong = 0, found = 0;  // sessions
  int worse = 0;  // commanded worse by the extended model than by kinematics
  Share parameters;
  double kinematics_mm = 0.0, extended_mm = 0.0, seconds = 0.0;  // medians
  double longest_s = 0.0;
};
[[nodiscard]] WorkshopSum sum_of(const std::vector<WorkshopOutcome>& outcomes);

/// Over `sessions` drawn rigs; `verbose` prints each session.
void print_workshop(
    int sessions, std::uint64_t first_seed, int threads, const WorkshopCase& of, bool verbose);

}  // namespace sixdial::blind
