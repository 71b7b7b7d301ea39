// What a fit's own columns cannot imitate, and the columns of effects that are not in it.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

using simulation::ActiveEffect;
using simulation::ExtendedModel;
using simulation::ModelVector;

int linear_count(const simulation::Effect& effect) {
  if (effect.is_curve) return 0;  // its coefficients are no parameters of a fit
  return static_cast<int>(effect.parameters.size()) - (effect.searched ? 1 : 0);
}

int fitted_count(const simulation::Effect& effect) {
  if (effect.is_curve) return 0;
  return static_cast<int>(effect.parameters.size()) -
         (effect.searched && !effect.searched_change ? 1 : 0);
}

Eigen::MatrixXd effect_columns(
    const Readings& readings, const ModelVector& at, const ExtendedModel& extended,
    const ActiveEffect& candidate, const Eigen::VectorXd& simulated_mm) {
  const int count = linear_count(*candidate.effect);
  Eigen::MatrixXd columns(readings.count(), count);
  for (int i = 0; i < count; ++i) {
    ActiveEffect moved = candidate;
    const auto k = static_cast<std::size_t>(i);
    const double step = 1e-3 * candidate.effect->parameters[k].sigma;
    moved.x[k] += step;
    columns.col(i) = (readings.simulate(at, extended, &moved) - simulated_mm) / step;
  }
  return columns.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

Projector::Projector(const JointFit& fit) : whitening_(fit.whitening()) {
  const Eigen::Index n = fit.residual_mm.size();
  const Eigen::Index m = fit.random.cols();
  Eigen::VectorXd e(n + m);
  e.head(n) = whitening_(fit.residual_mm);
  const Eigen::VectorXd own = fit.root_of_u();
  e.tail(m) = -own.cwiseProduct(fit.u);
  const Eigen::MatrixXd Q = orthonormal_basis(whitening_(fit.J), whitening_(fit.random), own);
  e -= Q * (Q.transpose() * e);
  Q_ = Q.topRows(n);
  Q_of_u_ = Q.bottomRows(m);
  e_ = e.head(n);
  squares_ = e.squaredNorm();
  freedom_ = std::max(3.0, fit.weight.sum() - fit.fitted);
}

}  // namespace sixdial::diagnosis
