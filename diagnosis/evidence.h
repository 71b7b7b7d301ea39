// How much better columns C explain a residual e than nothing does. Fair to a named effect with
// one amplitude and to a smooth function with many, as both are averaged over their prior:
//   log marginal likelihood of e ~ N(0, s^2 (I + t^2 C C')), s free,
//   mean over scales t of the prior, a logarithmic grid that begins at "just visible"
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace sixdial::diagnosis {

struct MarginalLikelihood {
  std::vector<double> by_scale;  // one for each t of the grid
  double best = 0.0;             // the largest
  double best_scale = 0.0;       // its t
  double explained = 0.0;        // fall of the sum of squares there
};
/// `normal` = C'C, `right` = C'e, `sse` = e'e, `freedom` = readings less fitted parameters.
/// Empty `by_scale` where the columns vanish. The grid goes as far as the signal does; `most`:
/// no t is larger.
[[nodiscard]] MarginalLikelihood marginal_likelihood(
    const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, double sse, double freedom,
    double most = std::numeric_limits<double>::infinity());

/// The same columns against many residuals, on a fixed grid: log_mean_exp of by_scale, 0 where
/// the columns vanish.
class MarginalEvidence {
 public:
  MarginalEvidence() = default;  // of no columns
  /// `most`: no t is larger.
  explicit MarginalEvidence(
      const Eigen::MatrixXd& normal, double most = std::numeric_limits<double>::infinity());
  /// Of its grid: how much its mean counts among those of other columns.
  [[nodiscard]] std::size_t scale_count() const { return scales_.size(); }
  [[nodiscard]] double operator()(
      const Eigen::VectorXd& right, double sse, double freedom) const;

 private:
  Eigen::MatrixXd vectors_;
  Eigen::VectorXd values_;
  std::vector<double> scales_;  // t^2
  std::vector<double> volume_;  // of each: half the sum of ln(1 + t^2 lambda)
};

/// Logarithm of the mean of exp(values).
[[nodiscard]] double log_mean_exp(const std::vector<double>& values);

}  // namespace sixdial::diagnosis
