// Sizes that physics forbids (EffectParameter::never_negative): backlash, and compliance under
// the plungers' forces, are never less than zero. A fit that wants them so has found something
// else. Sag under weight and growth by temperature may have either sign: a controller may make
// up for too much of them.
#pragma once

#include <cstddef>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// False if a size of effect number `cause` that cannot be negative lies more than three
/// standard deviations below zero, or if the effect has only such sizes and all are below zero.
[[nodiscard]] bool sizes_are_possible(const JointFit& fit, std::size_t cause);

}  // namespace sixdial::diagnosis
