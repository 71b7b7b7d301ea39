// Contact of the tool with a surface: a touch probe, the bed probe of a printer, a dial on a
// stand. One channel a surface, the tool's distance from it along its normal: 0 at contact, or
// what a dial shows. A plane that is not exactly known has three parameters (its height, and
// two tilts about axes in it), a sphere its centre.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind probe;

}  // namespace sixdial::geometry
