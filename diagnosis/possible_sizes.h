// Sizes that physics forbids: lost motion and compliance are never less than zero
// (EffectParameter::never_negative). A fit that wants them so has found something else that
// looks like it. Growth by temperature is not among them: a controller may make up for too
// much of it.
#pragma once

#include <cstddef>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// Whether effect number `cause` of the fit can have the sizes that it got. One that is never
/// negative may lie below zero by no more than its uncertainty; and of an effect none of whose
/// sizes is ever negative at least one is not below zero.
[[nodiscard]] bool sizes_are_possible(const JointFit& fit, std::size_t cause);

}  // namespace sixdial::diagnosis
