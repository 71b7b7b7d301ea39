// A target that lies outside of what was measured, in words.
#pragma once

#include <string>

#include "studies/measured_area.h"

namespace sixdial::report {

/// Of one target (`asked` 1) or of a plan; empty: all of it was measured.
[[nodiscard]] std::string outside_words(
    const studies::OutsideMeasured& outside, std::size_t asked);

}  // namespace sixdial::report
