// What held-out samples say against a name. The fitted effect itself foretells what it must do
// there: where that is well above the noise, and the readings do not follow it, the name is
// wrong, however well it fits where it was fitted.
#pragma once

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// Whether `log_odds`, those of a cause on the held-out readings, are too low for a cause that
/// is there. `with` and `without`: fits to the other readings. What effects of other samples
/// (a step that comes later) do there is nothing, and then nothing is asked.
[[nodiscard]] bool speaks_against(
    const Readings& held_out, const JointFit& with, const JointFit& without, double log_odds);

}  // namespace sixdial::diagnosis
