// Whether an instrument knows the frame in which it measures. A ball in sockets whose places
// nobody has measured does not: robot and sockets may stand anywhere together, and all that is
// found is in the frame of the robot's base. No kind is asked by name: where a shift of the
// whole robot is what other values of the instrument's own parameters would show as well, the
// frame is not known.
#pragma once

#include "geometry/rig.h"

namespace sixdial::geometry {

/// Of the instrument that the rig names (instrument_of). A place that is known to within a
/// deviation is known.
[[nodiscard]] bool knows_the_frame(const Rig& rig);

}  // namespace sixdial::geometry
