#include "diagnosis/evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace sixdial::diagnosis {

MarginalLikelihood marginal_likelihood(
    const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, double sse, double freedom) {
  constexpr double kSpan = 1e5;  // of t^2, in units of the least visible
  constexpr double kStep = 3.0;
  MarginalLikelihood result;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  const Eigen::VectorXd lambda = eigen.eigenvalues().cwiseMax(0.0);
  const Eigen::VectorXd c = eigen.eigenvectors().transpose() * right;
  const double largest = lambda.size() > 0 ? lambda.maxCoeff() : 0.0;
  if (!(largest > 0)) return result;
  result.best = -1e300;
  for (double t2 = 1.0 / largest; t2 < kSpan / largest; t2 *= kStep) {
    double explained = 0.0;
    double volume = 0.0;
    for (Eigen::Index j = 0; j < lambda.size(); ++j) {
      explained += c[j] * c[j] * t2 / (1 + t2 * lambda[j]);
      volume += std::log1p(t2 * lambda[j]);
    }
    explained = std::min(explained, sse * (1 - 1e-12));
    const double value = -0.5 * freedom * std::log1p(-explained / sse) - 0.5 * volume;
    result.by_scale.push_back(value);
    if (value > result.best) {
      result.best = value;
      result.best_scale = std::sqrt(t2);
      result.explained = explained;
    }
  }
  return result;
}

double log_mean_exp(const std::vector<double>& values) {
  const double top = *std::max_element(values.begin(), values.end());
  double sum = 0.0;
  for (const double value : values) sum += std::exp(value - top);
  return top + std::log(sum / static_cast<double>(values.size()));
}

}  // namespace sixdial::diagnosis
