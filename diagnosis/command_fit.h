// The fit that commands the robot: robot and named causes, and of all that is smooth only what
// the dials do by themselves. While causes are named, something smooth that nobody named may be
// fitted beside them (unknown.h), and what it takes over is then missing from the robot:
// parameters of that fit, commanded without the smooth part, miss by more than a fit without it
// does. What is smooth and nameless shows here as uncertainty of the parameters.
#pragma once

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// Fitted to all readings. The estimate is A y of the readings y, and its covariance A V A'
/// with V = s^2 (N^2 + C C') + D D': s N is the noise of each reading, C the smooth parts of
/// `named`, D the dials' error curves within their stated accuracy (error_curves) and what the
/// robot may have besides its names (unnamed.h).
[[nodiscard]] JointFit command_fit(const Readings& readings, const NamedCauses& named);

/// D: curves of each dial, smooth over its readings, with the standard deviation that a stated
/// accuracy of +-a means (a / sqrt(3), GUM 4.3.7) [mm]; count x columns, none without dials.
/// What a dial reads too much at one place it reads too much there every time: no number of
/// readings averages that out.
[[nodiscard]] Eigen::MatrixXd error_curves(const Readings& readings);

/// The covariance of `plain`'s parameters where the readings are as `structured` says, with
/// `curves` besides.
[[nodiscard]] Eigen::MatrixXd covariance_with_structure(
    const JointFit& plain, const JointFit& structured, const Eigen::MatrixXd& curves);

/// What no reading shows of a fit's parameters is no better known than before, to a plausible
/// change of each: the covariance that the directions N which no reading shows keep,
///   N (N' C^-1 N)^-1 N',   C the squares of plausible changes.
/// Of the model, then of what the fit moved in its causes; zero where everything is shown.
[[nodiscard]] Eigen::MatrixXd covariance_of_unseen(
    const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
