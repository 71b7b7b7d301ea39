// Names held against what dials do by themselves. Curves and habits within the makers' limits
// come into an explanation as far as they show beside the names that were there first; a name
// that takes their place must be worth more than they are, all let in anew.
#pragma once

#include "diagnosis/explanation.h"

namespace sixdial::diagnosis {

/// Leaves out names that the dials make needless, and exchanges those that have a better rival
/// once the dials are let in.
void hold_against_dials(
    const Search& search, const NamingSettings& settings, Explanation& found);

/// Whether `less`, which lacks a name of `found`, has more of the dials' own in it.
[[nodiscard]] bool dials_stand_in(const Explanation& found, const Explanation& less);

}  // namespace sixdial::diagnosis
