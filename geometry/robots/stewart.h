// A platform on six legs (Gough, Stewart): the pose at which every leg has its length.
//
//   |X_WE p_i - b_i| = q_i + leg_i,   b_i on the base (frame W), p_i on the platform (frame E)
//
// 42 parameters: the base's six joints, the platform's six, the zeros of the legs; where the
// machine stands is in its base joints. Lengths mm. The same leg lengths allow up to forty
// poses: this is the one that is reached from the middle pose (rig.toml: home_mm,
// home_turn_deg) without a jump. Degenerate: legs whose lines depend on each other, named
// kStretched.
#pragma once

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

extern const RobotKind stewart;

}  // namespace sixdial::geometry
