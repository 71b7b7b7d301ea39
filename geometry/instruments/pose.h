// An instrument that measures where the tool is and how it is turned: tracker with a 6-D probe,
// camera on a board. Channels x, y, z [mm] and the rotation vector rx, ry, rz [rad] of the
// tool's frame in W. Differences of rotation vectors are no turns: they grow across the axis,
// 1.6 times at half a turn, 71 times near a whole one. `nearest` gives a reading whose
// difference from what was measured is the turn between the two frames.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind pose_of_tool;

}  // namespace sixdial::geometry
