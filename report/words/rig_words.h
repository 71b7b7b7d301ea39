// How a rig stands to what its file states, in a sentence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/rig_seen.h"
#include "geometry/rig.h"

namespace sixdial::report {

/// "The rig stands within what its file states; off by most: place of dial C across its axis
/// 0.14 ± 0.02 mm, 1.4 times its stated standard deviation."; empty where nothing is stated.
[[nodiscard]] std::string rig_in_words(const std::vector<diagnosis::RigSeen>& rig);
/// That nobody said how well the dials' places are known; empty where somebody did, and where
/// there are no dials.
[[nodiscard]] std::string unsaid_of_rig(const geometry::Rig& rig);
/// One of the two, and how uncertain all positions are together. `of_rig_mm`: standard
/// uncertainty that the rig's geometry gives them (studies::rig_uncertainty_mm).
[[nodiscard]] std::vector<std::string> lines_on_rig(
    const std::optional<std::vector<diagnosis::RigSeen>>& seen, const geometry::Rig& rig,
    double of_rig_mm);

}  // namespace sixdial::report
