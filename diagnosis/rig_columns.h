// What the rig's own geometry does to the readings.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/readings.h"
#include "simulation/rig_quantities.h"

namespace sixdial::diagnosis {

/// Change of each reading [mm] where a quantity is off by its standard deviation, count x
/// quantities, by the plain model. 0 where the pose does not exist.
[[nodiscard]] Eigen::MatrixXd rig_columns(
    const Readings& readings, const simulation::ModelVector& at,
    const std::vector<simulation::RigQuantity>& quantities);

}  // namespace sixdial::diagnosis
