// A dial whose scale is uneven by more than its maker allows: a smooth function of its own
// reading which no effect of the catalogue explains as well.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/explanation.h"

namespace sixdial::diagnosis {

/// `rivals`: the smooth functions that would do about as well as number `i` of `found.unknown`.
/// Empty where that function is none of a dial's own reading, or may be within the dial's
/// accuracy_mm: it stays without a name then.
[[nodiscard]] std::optional<DialCurve> dial_curve_of(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, std::size_t i, const std::vector<UnknownCandidate>& rivals);

/// What stands at a dial beside an unnamed or named function of the same dial's reading may be
/// a part of it: tied with it.
void doubt_beside_curves(
    const Readings& readings, const Explanation& found, NamedCauses& names);

}  // namespace sixdial::diagnosis
