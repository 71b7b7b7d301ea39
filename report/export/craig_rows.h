// An arm of turning joints as rows of Craig's convention, four numbers a joint: exact for any
// arm, because only where the axes lie matters. Two axes that are nearly parallel have their
// common normal far away, so that d of their rows is large and cancels out.
//
//   X_WE = base * row 1(q1) * ... * row n(qn) * tool,
//   row(q) = Rx(alpha) Tx(a) Rz(q + theta) Tz(d)
//
// Degenerate: axes within 1e-8 rad of each other count as parallel. Accuracy: 1e-16 of the
// largest d; computed with long doubles.
#pragma once

#include <vector>

#include "report/export/joint_chain.h"

namespace sixdial::report {

struct CraigRow {
  double a_mm = 0.0, alpha_rad = 0.0;  // from the axis before
  double d_mm = 0.0, theta_rad = 0.0;  // theta: what is added to the encoder's angle
};

struct CraigArm {
  geometry::Pose<double> base{}, tool{};
  std::vector<CraigRow> rows{};
};

/// All joints turn and none follows another. The first row has neither a nor alpha.
[[nodiscard]] CraigArm craig_arm(const JointChain& chain);

}  // namespace sixdial::report
