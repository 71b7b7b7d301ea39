// The fit that commands the robot: robot and named causes alone. While causes are named,
// something smooth that nobody named may be fitted beside them (unknown.h), and what it takes
// over is then missing from the robot: parameters of that fit, commanded without the smooth
// part, miss by more than a fit of robot and causes alone does. What is smooth and nameless
// shows here as uncertainty of the parameters.
#pragma once

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// To all readings. Its covariance is that of this estimate where the readings have the noise
/// and the smooth parts of `named`: with V = s^2 (N^2 + C C') and the estimate A y, A V A'.
[[nodiscard]] JointFit command_fit(const Readings& readings, const NamedCauses& named);

/// The covariance of `plain`'s parameters where the readings are as `structured` says.
[[nodiscard]] Eigen::MatrixXd covariance_with_structure(
    const JointFit& plain, const JointFit& structured);

}  // namespace sixdial::diagnosis
