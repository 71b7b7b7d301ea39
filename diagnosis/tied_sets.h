// Several places of one effect can stand for several others together, where no single exchange
// does: dials C and D moved forward are dials E and F moved back, on a robot that stands
// elsewhere.
#pragma once

#include <vector>

#include "diagnosis/explanation.h"

namespace sixdial::diagnosis {

/// Where another set of as many places explains the readings about as well, each finding that
/// is not in it gets those of its places that were not found as rivals.
void tie_alike_sets(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, const std::vector<Search::Exchange>& exchanges,
    std::vector<Finding>& findings);

}  // namespace sixdial::diagnosis
