// Dial indicators that touch a square cuboid at the tool (spec 1): one channel a dial, its
// displacement. contact.h has the geometry of one dial. One parameter, the clamp angle of the
// cuboid against its link; held freely, its rotation gamma is an unknown of each sample.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

extern const InstrumentKind dials_on_cuboid;

}  // namespace sixdial::geometry
