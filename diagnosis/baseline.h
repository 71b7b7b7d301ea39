// The robot fitted without any cause, from the nominal one. A dial whose tip leaves its face
// reads millimetres off, and enough of such readings pull a fit somewhere from where it does
// not come back: then it is tried from where it would be without each dial in turn.
#pragma once

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

[[nodiscard]] JointFit fit_baseline(const Readings& readings);

/// Many gross readings, or an error far above the rig's noise: exchanged dials, or a fit that
/// settled on a part of the session.
[[nodiscard]] bool looks_wrong(const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
