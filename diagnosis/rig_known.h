// How well a rig is known whose file claims exactness and is wrong: kind by kind (places across
// the axes, tip radii, ...), as far as the readings tell, and as a workshop knows it otherwise.
//
// With names and robot in the fit, x_j is what quantity j of a kind is off by, in what a
// workshop knows of it: x_j ~ N(0, t^2). Each kind's t is raised to the largest posterior
// density by expectation maximisation (Dempster, Laird, Rubin 1977):
//   t^2 = (1 + sum_j (E[x_j]^2 + Var[x_j])) / (1 + n)
// where the 1 is the workshop's own figure, which counts as one more quantity of the kind. Of a
// kind that the readings say nothing of, Var[x_j] is 1 and t stays 1.
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
