// Lengths from anchors to the tool: draw wires, ball bars, telescoping bars. One channel an
// anchor, its name; the anchor's place is three parameters where it is not exactly known.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind distance;

}  // namespace sixdial::geometry
