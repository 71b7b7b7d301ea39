// The outermost points of a plan: where a first pass goes before anything is measured.
#pragma once

#include "session/plan.h"

namespace sixdial::session {

/// Of each branch the points farthest out in eight directions, in the plan's order; a point
/// once. All of a small plan.
[[nodiscard]] Plan outermost(const geometry::Rig& rig, const Plan& plan);

}  // namespace sixdial::session
