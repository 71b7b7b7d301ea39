// How well a rig is known whose file claims exactness and is wrong: kind by kind (places across
// the axes, tip radii, ...), as far as the readings tell, and as a workshop knows it otherwise.
//
// x_j is how far quantity j of a kind is off, in standard deviations that a workshop reaches;
// its prior is N(0, t^2), one t for each kind. With names and robot in the fit, the t of the
// largest posterior density are found by expectation maximisation (Dempster, Laird, Rubin
// 1977):
//   t^2 = (1 + sum_j (E[x_j]^2 + Var[x_j])) / (1 + n)
// where the 1 is the workshop's own figure, which counts as one more quantity of the kind. t
// grows where the readings show large deviations, shrinks where they show small ones, and stays
// 1 where they show nothing (Var[x_j] is 1).
#pragma once

#include <vector>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

struct RigKnown {
  std::vector<double> of_a_workshop;  // for Readings::allowing_rig_by
  JointFit fit;                       // on readings that allow that
};

/// Begins with a rig as a workshop knows it, whatever `readings` allow; `fit` is of them, and
/// its smooth functions stay in it. A fit that does not settle ends it: what was reached before
/// stands.
[[nodiscard]] RigKnown rig_known(const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
