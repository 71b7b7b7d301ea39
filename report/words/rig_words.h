// How a rig stands to what its file states, in a sentence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/rig_seen.h"
#include "geometry/rig.h"
#include "studies/conformity.h"

namespace sixdial::report {

/// "The rig stands within what its file states; off by most: place of dial C across its axis
/// 0.14 ± 0.02 mm, 1.4 times its stated standard deviation."; empty where nothing is stated.
[[nodiscard]] std::string rig_in_words(const std::vector<diagnosis::RigSeen>& rig);
/// That nobody said how well the dials' places are known; empty where somebody did, and where
/// there are no dials.
[[nodiscard]] std::string unsaid_of_rig(const geometry::Rig& rig);
/// That the file states something, but nothing was fitted along with the robot; else empty.
[[nodiscard]] std::string unfitted_rig(
    const std::optional<std::vector<diagnosis::RigSeen>>& seen, const geometry::Rig& rig);
/// One of the three, and how uncertain all positions are together.
[[nodiscard]] std::vector<std::string> lines_on_rig(
    const std::optional<std::vector<diagnosis::RigSeen>>& seen, const geometry::Rig& rig,
    const studies::SharedUncertainty& of_rig);

}  // namespace sixdial::report
