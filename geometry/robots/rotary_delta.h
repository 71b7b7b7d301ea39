// Three motors with upper arms in vertical planes, two parallel rods from each to a platform
// that does not turn.
//
//   |knee - p| = rod,  knee = Rz(angle) (radius + arm cos(q + zero), 0, -arm sin(q + zero))
//
// Frame B: z up, the motors in z = 0; q = 0 is an arm held out flat, positive down; `radius` is
// that of the motors less that of the platform's joints. Degenerate: rods that do not reach, or
// lie flat.
#pragma once

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

extern const RobotKind rotary_delta;

}  // namespace sixdial::geometry
