// A ball on the tool put into sockets: the tool is at the same place whenever the same socket
// is named, and no instrument is needed. Channels S1_x, S1_y, S1_z [mm], the tool's place less
// the socket's: 0 while the ball sits in it. Sockets that nobody has measured have three
// parameters each; where the distance of two of them is known, it holds the scale.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind socket;

}  // namespace sixdial::geometry
