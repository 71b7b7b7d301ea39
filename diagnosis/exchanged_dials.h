// Two dials whose readings come under each other's name: cables or channels mixed up.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/search.h"

namespace sixdial::diagnosis {

/// Looks for two exchanged dials, but only where much of the session is gross or far off. An
/// exchange has no size that a fit could find, so each pair is tried by exchanging its
/// readings. Returns the pair that explains the session best, if it does so beyond doubt;
/// `readings` and `baseline` are then those with the exchange undone. `baseline` may also come
/// back without a pair, as a likelier fit that was met on the way.
[[nodiscard]] std::optional<Hypothesis> find_exchanged_dials(
    Readings& readings, const std::vector<Hypothesis>& hypotheses, JointFit& baseline);

}  // namespace sixdial::diagnosis
