// The live estimate in words, for the screen of a collection.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "studies/live_estimate.h"

namespace sixdial::report {

/// "estimate after 43 samples: positions are known to 0.0042 mm on average and ...".
[[nodiscard]] std::string estimate_summary(const studies::EstimateSummary& estimate);
/// Each parameter with its standard deviation, `in_line` of them in a line.
[[nodiscard]] std::vector<std::string> estimate_parameters(
    const studies::EstimateSummary& estimate, std::size_t in_line = 3);

}  // namespace sixdial::report
