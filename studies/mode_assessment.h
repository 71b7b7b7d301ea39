// A session measured in several working modes: how well each would determine the parameters by
// itself, beside all pooled.
#pragma once

#include <span>
#include <string>

#include "calibration/least_squares.h"
#include "calibration/observation_space.h"
#include "geometry/rig.h"
#include "simulation/trial.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

/// [{mode, samples, condition}] in order of appearance, one for a session in one mode.
/// `condition`: of the scaled Jacobian's rows of that mode at the fit's answer; null where they
/// leave a direction open. `trials` must hold the samples of the space.
[[nodiscard]] Json working_modes_json(
    const calibration::ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

/// "condition number by working mode: ++ 379 (50 samples), -+ 402 (50); pooled 151"; empty for
/// one mode.
[[nodiscard]] std::string working_modes_line(const Json& modes, const Json& pooled_condition);

}  // namespace sixdial::studies
