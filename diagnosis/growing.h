// The first part of naming: names are added one by one, as long as each is worth it.
#pragma once

#include "diagnosis/explanation.h"
#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// The suspicion that the rig is not as its file says; null: there is none.
[[nodiscard]] const UnknownCandidate* rig_of(const Explanation& found);

/// Adds names one by one; at each number of names, smooth functions add what they can. Goes on
/// for two names past the best of all these, which is returned. `result` gets what the first
/// search over all candidates found. Ends early where the rig's geometry explains more than a
/// few names do: then its stated exactness is given up first (naming.cpp), and all asked again.
[[nodiscard]] Explanation best_of_growing(
    const Search& search, const NamingSettings& settings, NamedCauses& result);

}  // namespace sixdial::diagnosis
