// An instrument that measures where the tool is: laser tracker, coordinate measuring machine,
// camera. Channels x, y (and z) in W [mm]; no parameters.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind position;

}  // namespace sixdial::geometry
