// An instrument that measures where the tool is and how it is turned: tracker with a 6-D probe,
// camera on a board. Channels x, y, z [mm] and the rotation vector rx, ry, rz [rad] of the
// tool's frame in W. A rotation vector has many values for one turn: `nearest` takes the one
// that lies nearest to what was measured.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind pose_of_tool;

}  // namespace sixdial::geometry
