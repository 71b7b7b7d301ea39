// An instrument that measures where the tool is and how it is turned: tracker with a 6-D probe,
// camera on a board. Channels x, y, z [mm] and the rotation vector rx, ry, rz [rad] of the
// tool's frame in W. The difference of two rotation vectors is not the turn between their
// frames: across the axis of rotation it is larger by (a/2) / sin(a/2) at an angle a, 1.6 times
// at 180 degrees. `nearest` shifts the reading so that measured - reading is that turn.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind pose_of_tool;

}  // namespace sixdial::geometry
