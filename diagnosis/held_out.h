// What held-out samples say against a name. The fitted effect itself foretells what it must do
// there: where that is well above the noise, and the readings do not follow it, the name is
// wrong, however well it fits where it was fitted.
#pragma once

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// True if `log_odds` (held-out readings, with against without the cause) are negative and more
/// than 2.5 standard deviations below what the fitted effect foretells. `with` and `without`:
/// fits to the other readings. False for an effect that changes no held-out reading.
[[nodiscard]] bool speaks_against(
    const Readings& held_out, const JointFit& with, const JointFit& without, double log_odds);

}  // namespace sixdial::diagnosis
