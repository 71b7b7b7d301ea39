// An instrument that measures where the tool is: laser tracker, coordinate measuring machine,
// camera. Channels x, y (and z) in W [mm]; of more points on the tool x_P2, y_P2, z_P2, whose
// places in the tool's frame are parameters where they are not exactly known.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind position;

}  // namespace sixdial::geometry
