// Where an instrument knows no frame (a ball in sockets whose places nobody has measured), a
// robot is found in the frame of its own base: where that stands is not asked.
#pragma once

#include <vector>

#include "geometry/rig.h"

namespace sixdial::studies {

/// Marks the parameters of where the robot stands as fixed, if nothing that the instrument
/// refers to has a known place. `fixed`: by parameter of a space, the robot's first.
void hold_where_it_stands(const geometry::Rig& rig, std::vector<char>& fixed);

}  // namespace sixdial::studies
