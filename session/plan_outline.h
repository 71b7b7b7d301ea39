// The outermost points of a plan: where a first pass goes before anything is measured.
#pragma once

#include "session/plan.h"

namespace sixdial::session {

/// Of points that follow each other in one branch those farthest out in eight directions of x
/// and y, in the plan's order; a point once. Points inside are left out, of a small plan too.
[[nodiscard]] Plan outermost(const geometry::Rig& rig, const Plan& plan);

}  // namespace sixdial::session
