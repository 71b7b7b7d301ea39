// What a least-squares fit says about itself, and the fit that gross errors do not pull.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "calibration/least_squares.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRobustRounds = 20;
constexpr double kRobustScale = 2.5;     // in standard deviations
constexpr double kRobustSettled = 1e-9;  // relative change of the residuals

/// Standard deviation of one residual from the median size of the blocks, which gross errors do
/// not move: the median of |r| is 0.6745 sigma, that of a pair's length sigma sqrt(2 ln 2).
double robust_sigma(const VectorXd& residual, int block) {
  std::vector<double> sizes;
  for (Eigen::Index i = 0; i + block <= residual.size(); i += block) {
    sizes.push_back(residual.segment(i, block).norm());
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  return *middle / (block == 1 ? 0.6744897501960817 : std::sqrt(2.0 * std::numbers::ln2));
}

}  // namespace

std::string_view describe(FitStatus status) {
  switch (status) {
    case FitStatus::kConverged:
      return "converged";
    case FitStatus::kIterationLimit:
      return "stopped at the iteration limit before it converged";
    case FitStatus::kBadStart:
      return "the model has no value at the start (a pose cannot be reached)";
  }
  return "unknown fit status";
}

double LeastSquaresFit::condition() const {
  if (singular_values.size() == 0) return 1.0;
  return singular_values[0] / singular_values[singular_values.size() - 1];
}

int LeastSquaresFit::degrees_of_freedom() const {
  return static_cast<int>(residual.size()) - (free - held);
}

double LeastSquaresFit::variance() const {
  const int freedom = degrees_of_freedom();
  return freedom > 0 ? rss / freedom : 0.0;
}

Eigen::MatrixXd LeastSquaresFit::unit_covariance() const {
  const auto n = singular_values.size() - held;
  const MatrixXd root = scale.asDiagonal() * directions.leftCols(n) *
                        singular_values.head(n).cwiseInverse().asDiagonal();
  return root * root.transpose();
}

LeastSquaresFit solve_robustly(
    const LeastSquaresProblem& problem, const Eigen::VectorXd& start,
    LeastSquaresSettings settings, Loss loss, int block) {
  settings.loss = Loss::kSquare;
  settings.block = 1;
  LeastSquaresFit fit = solve_least_squares(problem, start, settings);
  if (loss == Loss::kSquare || fit.status == FitStatus::kBadStart) return fit;
  settings.loss = loss;
  settings.block = block;
  const double least_scale = settings.loss_scale;
  for (int round = 0; round < kRobustRounds; ++round) {
    const double sigma = robust_sigma(fit.residual, block);
    if (sigma <= 0.0) break;
    settings.loss_scale = std::max(kRobustScale * sigma, least_scale);
    const double before = fit.rss;
    fit = solve_least_squares(problem, fit.x, settings);
    if (std::abs(fit.rss - before) < kRobustSettled * before) break;
  }
  return fit;
}

}  // namespace sixdial::calibration
