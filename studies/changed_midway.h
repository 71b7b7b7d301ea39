// A dial that reads otherwise from some row on: its zero was set, its unit, its plug, its
// place. Asked of a fit that has set aside what stands out: one change accuses many readings of
// the dial, which are no accidents.
#pragma once

#include <span>
#include <vector>

#include "calibration/gross_errors.h"
#include "session/session.h"
#include "simulation/trial.h"
#include "studies/plausibility.h"

namespace sixdial::studies {

/// `trials`: all of the session that count, in its order. `fitted`: what was found in G1.
[[nodiscard]] std::vector<Warning> changed_midway(
    std::span<const simulation::Trial> trials, const session::Session& session,
    const calibration::GrossErrorCheck& fitted);

}  // namespace sixdial::studies
