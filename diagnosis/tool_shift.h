// What a sample's residuals say of the tool: the shift of it that explains them best.
#pragma once

#include <Eigen/Core>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// d(readings)/d(shift of the tool) and d/d(angle of the cuboid), count x axes and count x 1.
struct ToolColumns {
  Eigen::MatrixXd shift;
  Eigen::VectorXd turn;  // empty in a session of positions
};
[[nodiscard]] ToolColumns tool_columns(const Readings& readings, const JointFit& fit);

/// By sample, the cuboid's angle free where the contacts allow it; axes x trials [mm], NaN
/// where there are too few readings.
[[nodiscard]] Eigen::MatrixXd tool_shift(
    const Readings& readings, const JointFit& fit, const Eigen::VectorXd& residual_mm,
    const Eigen::VectorXd& weight);

}  // namespace sixdial::diagnosis
