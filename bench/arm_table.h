// The table of the blind challenge on robot arms.
#pragma once

#include <cstdint>

namespace sixdial::blind {

/// `sessions` of each line; prints as it goes. Number of figures that were not reached.
int print_arms(int sessions, std::uint64_t first_seed, int threads, bool verbose);

}  // namespace sixdial::blind
