// A space with more unknowns than its own parameters, each known to within something before:
// where a dial stands, how its error curve bends. Each is a parameter by which rows change
// linearly, and a sample that says: it is what was known, to within one standard deviation. So
// every method of fitting takes them along without knowing of them.
//
//   const ObservationSpace all = with_known(dial_space(trials, rig), columns);
//   const SpaceFit fit = fit_space(all, {.weighting = Weighting::kBySigma});
#pragma once

#include <Eigen/Core>

#include "calibration/observation_space.h"

namespace sixdial::calibration {

/// `columns`: change of each row [mm] for one standard deviation of a quantity, rows x
/// quantities. `known`: what was known of each, in standard deviations; empty: 0. The
/// quantities are the last parameters, in standard deviations times known_unit_mm(space), so
/// that they and their samples weigh like readings.
[[nodiscard]] ObservationSpace with_known(
    ObservationSpace space, const Eigen::MatrixXd& columns, const Eigen::VectorXd& known = {});
/// What one standard deviation of such a quantity is as a parameter: the readings' mean sigma.
[[nodiscard]] double known_unit_mm(const ObservationSpace& space);

}  // namespace sixdial::calibration
