// The least-squares core: Levenberg-Marquardt on any residuals with an analytic Jacobian, by
// singular values, so that directions the data cannot tell are seen, held and named, never
// walked away along. Positions, dial readings and the certified NIST sets all go through here.
//
// Held directions: the fit moves only in directions the data determine; the rest stays where
// the anchor (the nominal parameters) has it, in scaled coordinates u = x / scale. So the
// answer does not depend on the start.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string_view>
#include <vector>

namespace sixdial::calibration {

struct LeastSquaresProblem {
  int parameters = 0;
  int residuals = 0;
  /// Fills r (residuals) and, unless null, J = dr/dx (residuals x parameters). False where the
  /// model has no value at x.
  std::function<bool(const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd* J)>
      evaluate;
  /// For speed, or empty: J'J (lower triangle, parameters x parameters), J'r and r'r at x,
  /// equal to those of `evaluate` up to rounding. All come in with the right size. False where
  /// the model has no value at x. The core takes the first steps with it while every direction
  /// is well determined, and lets `evaluate` and singular values say the last word.
  std::function<bool(
      const Eigen::VectorXd& x, Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr, double& rss)>
      normal = {};
};

/// What a residual block costs: s = its squared norm.
enum class Loss {
  kSquare,  // s
  kHuber,   // s up to scale^2, then linear in the norm
  kCauchy,  // scale^2 log(1 + s / scale^2)
};

struct LeastSquaresSettings {
  int max_iterations = 300;
  /// First damping relative to the largest squared singular value. Small: begins as
  /// Gauss-Newton, right where the start is near or the valley is long.
  double first_damping = 1e-3;
  Eigen::VectorXd scale;    // of each parameter; empty: largest column norm seen (Marquardt)
  Eigen::VectorXd anchor;   // where held directions stay; empty: the start
  std::vector<char> fixed;  // 1: the parameter keeps its start value; empty: all free
  double hold_below = 0.0;  // singular value of J diag(scale) under which a direction is held
  double hold_relative = 1e-12;  // the same relative to the largest
  Loss loss = Loss::kSquare;
  double loss_scale = 1.0;
  int block = 1;  // residuals that belong together (2: x and y of one position)
  /// Ends where every further step together would be less than this many standard deviations
  /// of the parameters; 0: at the minimum, to within rounding.
  double enough = 0.0;
};

enum class FitStatus {
  kConverged,
  kIterationLimit,
  kBadStart,  // the model has no value at the start
};
[[nodiscard]] std::string_view describe(FitStatus status);

struct LeastSquaresFit {
  FitStatus status = FitStatus::kBadStart;
  Eigen::VectorXd x;
  Eigen::VectorXd residual;          // at x, not weighted
  Eigen::MatrixXd J;                 // at x, all columns, not weighted
  double rss = 0.0;                  // squared norm of `residual`
  double cost = 0.0;                 // with the loss
  std::vector<double> block_weight;  // of the loss, 1 for kSquare
  int iterations = 0;
  int evaluations = 0;

  Eigen::VectorXd scale;            // used
  Eigen::VectorXd singular_values;  // of the weighted J diag(scale), free columns, falling
  Eigen::MatrixXd directions;       // parameters x free: right singular vectors in u
  int held = 0;                     // how many of the last directions are held
  int free = 0;

  [[nodiscard]] double condition() const;
  [[nodiscard]] int degrees_of_freedom() const;
  /// rss / degrees of freedom; 0 when there are none.
  [[nodiscard]] double variance() const;
  /// (J'WJ)^-1 in the determined directions, zero in held and fixed ones. Times the variance of
  /// one residual it is the covariance of x.
  [[nodiscard]] Eigen::MatrixXd unit_covariance() const;
};

[[nodiscard]] LeastSquaresFit solve_least_squares(
    const LeastSquaresProblem& problem, const Eigen::VectorXd& start,
    const LeastSquaresSettings& settings = {});

/// With a robust loss: from the plain minimum, with a scale that shrinks to 2.5 robust standard
/// deviations of the residuals (settings.loss_scale at least). A robust loss has many minima;
/// this one forgives only what stands out from everything else. `block`: residuals that belong
/// together. settings.loss is ignored.
[[nodiscard]] LeastSquaresFit solve_robustly(
    const LeastSquaresProblem& problem, const Eigen::VectorXd& start,
    LeastSquaresSettings settings, Loss loss, int block);

}  // namespace sixdial::calibration
