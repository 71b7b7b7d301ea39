// Where the tool was, by all readings of a sample and with what a fitted model says is wrong
// with the instrument (a dial that reads too much, for example, or a cuboid of another size).
#pragma once

#include <Eigen/Core>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

/// By trial [mm], NaN where the readings do not tell. The model's own tool position is only
/// where the search starts: it has to be near. Of five or more readings the one that
/// contradicts the others is left out.
[[nodiscard]] Eigen::MatrixXd explained_positions(
    const Readings& readings, const simulation::ModelVector& model,
    const std::vector<simulation::ActiveEffect>& effects, double noise_mm);

}  // namespace sixdial::diagnosis
