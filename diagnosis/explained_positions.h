// Where the tool was, by all readings of a sample and with what a fitted model says of the
// instrument: a dial that reads too much or stands elsewhere, a cuboid of another size.
#pragma once

#include <Eigen/Core>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

/// By trial [mm], NaN where the readings do not tell. What the model says of robot and tool
/// cancels out: it only has to be near. A reading that contradicts the others is left out.
[[nodiscard]] Eigen::Matrix2Xd explained_positions(
    const Readings& readings, const simulation::ModelVector& model,
    const std::vector<simulation::ActiveEffect>& effects, double noise_mm);

}  // namespace sixdial::diagnosis
