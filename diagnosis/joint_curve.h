// The joints' curves of a verdict, fitted anew to a part of the readings and made a part of the
// model: what is judged on other readings, and what the robot is commanded by.
#pragma once

#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// Where three joints or more each err by their own angle, as the drives of a real arm do:
/// their curves, found before any name. One by one they would pass for many small causes. Empty
/// otherwise, and in the plane.
[[nodiscard]] std::vector<JointCurve> find_joint_curves(
    const Readings& readings, const NamingSettings& settings);

/// `from`, a fit to these readings, with the joints' curves fitted too and then held as effects
/// at its end. `random`: columns that stay random. The curves' smoothness and size are those
/// that were found; their form is what these readings say.
[[nodiscard]] JointFit with_joint_curves(
    const Readings& readings, const JointFit& from, const std::vector<JointCurve>& curves,
    const Eigen::MatrixXd& random = {});

}  // namespace sixdial::diagnosis
