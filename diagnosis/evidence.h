// How much better columns explain a residual than nothing does, fair to a named effect with one
// amplitude and to a smooth function with many: log marginal likelihood of e ~ N(0, s^2 (I +
// t^2 C C')), s free, averaged over the prior's scale t on a logarithmic grid from "just
// visible" up.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sixdial::diagnosis {

struct MarginalLikelihood {
  std::vector<double> by_scale;  // one for each t of the grid
  double best = 0.0;             // the largest
  double best_scale = 0.0;       // its t
  double explained = 0.0;        // fall of the sum of squares there
};
/// `normal` = C'C, `right` = C'e, `sse` = e'e, `freedom` = readings less fitted parameters.
/// Empty `by_scale` where the columns vanish.
[[nodiscard]] MarginalLikelihood marginal_likelihood(
    const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, double sse, double freedom);

/// Logarithm of the mean of exp(values).
[[nodiscard]] double log_mean_exp(const std::vector<double>& values);

}  // namespace sixdial::diagnosis
