// A comparison of all methods, as the screen shows it.
#pragma once

#include <string>

#include "studies/compare.h"

namespace sixdial::report {

/// Table 6 for every method, times beside it; below it how the rig stands to its file, where it
/// was fitted along.
[[nodiscard]] std::string comparison_text(const studies::ComparisonResult& result);
/// What the figures of "before" are differences of: "measured minus target".
[[nodiscard]] const char* before_in_words(bool before_uses_targets);

}  // namespace sixdial::report
