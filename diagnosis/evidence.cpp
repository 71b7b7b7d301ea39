#include "diagnosis/evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace sixdial::diagnosis {
namespace {

constexpr double kSpan = 1e5;  // of t^2, in units of the least visible
constexpr double kStep = 3.0;

}  // namespace

MarginalLikelihood marginal_likelihood(
    const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, double sse, double freedom,
    double most) {
  MarginalLikelihood result;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  const Eigen::VectorXd lambda = eigen.eigenvalues().cwiseMax(0.0);
  const Eigen::VectorXd c = eigen.eigenvectors().transpose() * right;
  const double largest = lambda.size() > 0 ? lambda.maxCoeff() : 0.0;
  if (!(largest > 0)) return result;
  result.best = -1e300;
  // A signal that is larger than the span goes on as long as a wider prior explains it better.
  const auto still_rises = [&] {
    const std::size_t tried = result.by_scale.size();
    return tried > 1 && result.by_scale[tried - 1] > result.by_scale[tried - 2];
  };
  for (double t2 = 1.0 / largest; t2 < kSpan / largest || still_rises(); t2 *= kStep) {
    if (t2 > most * most && !result.by_scale.empty()) break;
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

MarginalEvidence::MarginalEvidence(const Eigen::MatrixXd& normal, double most) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  vectors_ = eigen.eigenvectors();
  values_ = eigen.eigenvalues().cwiseMax(0.0);
  const double largest = values_.size() > 0 ? values_.maxCoeff() : 0.0;
  if (!(largest > 0)) return;
  for (double t2 = 1.0 / largest; t2 < kSpan / largest; t2 *= kStep) {
    if (t2 > most * most && !scales_.empty()) break;
    scales_.push_back(t2);
    volume_.push_back(0.5 * (t2 * values_).array().log1p().sum());
  }
}

double MarginalEvidence::operator()(
    const Eigen::VectorXd& right, double sse, double freedom) const {
  if (scales_.empty()) return 0.0;
  const Eigen::VectorXd c = vectors_.transpose() * right;
  double top = -1e300;
  double sum = 0.0;  // of exp(value - top)
  for (std::size_t i = 0; i < scales_.size(); ++i) {
    const double t2 = scales_[i];
    double explained = 0.0;
    for (Eigen::Index j = 0; j < c.size(); ++j) {
      explained += c[j] * c[j] * t2 / (1 + t2 * values_[j]);
    }
    explained = std::min(explained, sse * (1 - 1e-12));
    const double value = -0.5 * freedom * std::log1p(-explained / sse) - volume_[i];
    if (value > top) {
      sum = sum * std::exp(top - value) + 1.0;
      top = value;
    } else {
      sum += std::exp(value - top);
    }
  }
  return top + std::log(sum / static_cast<double>(scales_.size()));
}

double log_mean_exp(const std::vector<double>& values) {
  const double top = *std::max_element(values.begin(), values.end());
  double sum = 0.0;
  for (const double value : values) sum += std::exp(value - top);
  return top + std::log(sum / static_cast<double>(values.size()));
}

}  // namespace sixdial::diagnosis
