// Two dials whose readings come under each other's name: cables or channels mixed up.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/search.h"

namespace sixdial::diagnosis {

/// Tried only where much of the session is gross or far off, by exchanging the readings: it has
/// no size that a fit could find. The pair whose exchange explains the session best, if it does
/// so beyond doubt; then `readings` and `baseline` come out with the exchange undone.
[[nodiscard]] std::optional<Hypothesis> find_exchanged_dials(
    Readings& readings, const std::vector<Hypothesis>& hypotheses, JointFit& baseline);

}  // namespace sixdial::diagnosis
