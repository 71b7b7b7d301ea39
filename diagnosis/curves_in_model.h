// The curves of a verdict, of dials over their readings and of joints over their values, fitted
// anew to a part of the readings and made a part of the model: what is judged on other
// readings, what positions are computed with, and what the robot is commanded by.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// The curve over a dial's own reading. Not null.
[[nodiscard]] const simulation::Effect* curve_of_dials();

/// `from`, a fit to these readings, with the curves fitted too and then held as effects at its
/// end. The curves' smoothness and size are those that were found; their form is what these
/// readings say. `random`: columns that stay random. `kept`: the same afterwards; empty: as
/// before.
[[nodiscard]] JointFit with_curves(
    const Readings& readings, const JointFit& from, const std::vector<OwnCurve>& curves,
    const Eigen::MatrixXd& random = {}, const std::optional<Eigen::MatrixXd>& kept = {});

}  // namespace sixdial::diagnosis
