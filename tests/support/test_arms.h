// Two robot kinds that only the tests know, added to the registry at run time: the laws hold
// for them as for the kinds of the program, so the seam is not made for one robot alone.
#pragma once

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

/// A planar arm of two links on a base that may stand anywhere, with a prismatic wrist across
/// the second link. It has an inverse for the wrist at rest.
const RobotKind& planar_arm();
/// Six axes by Denavit-Hartenberg rows, the third one prismatic: 30 parameters, poses in space.
const RobotKind& spatial_arm();

}  // namespace sixdial::geometry
