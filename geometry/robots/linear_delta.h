// Three carriages on vertical towers, a rod from each to a platform that does not turn.
//
//   |c - p| = rod,  c = (radius cos a, radius sin a, q + stop)   for each tower A, B, C
//
// Frame B: z up along the towers; `radius` is that of the towers' joints less that of the
// platform's. Lengths mm. Degenerate: rods that do not reach, or lie flat.
#pragma once

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

extern const RobotKind linear_delta;

}  // namespace sixdial::geometry
