// Fits the robot without any cause, starting at the nominal one. A dial whose tip leaves its
// face reads millimetres off, and enough such readings pull the fit to a wrong place that it
// does not leave again. If that seems to have happened, the session is fitted without each dial
// in turn, all readings again from there, and the likeliest fit is kept.
#pragma once

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// To be given to fit_jointly as `near`: any reading may be gross from the first step on,
/// whereas a fit from afar counts them all until its steps are small. Readings that are off by
/// centimetres (a tip beyond its face) draw all such steps their way.
[[nodiscard]] JointFit doubtful_start();

[[nodiscard]] JointFit fit_baseline(const Readings& readings);

/// True if many readings are gross, or the error is far above the rig's noise: either two dials
/// are exchanged, or the fit explains only a part of the session.
[[nodiscard]] bool looks_wrong(const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
