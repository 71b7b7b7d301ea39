// Dials that scatter more than the others. With one noise for all dials, their scatter would be
// taken for causes.
#pragma once

#include <vector>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// Noise of each dial [mm] after all that was explained, if one differs from the others by more
/// than chance (F test) and by enough to matter; else empty.
[[nodiscard]] std::vector<double> uneven_noise(const Readings& readings, const JointFit& fit);

/// What it costs in log evidence that the readings give each dial a noise of its own instead of
/// the rig file's.
[[nodiscard]] double noise_cost(const Readings& readings);

}  // namespace sixdial::diagnosis
