#include "diagnosis/estimates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Of fit.J, for effect number `cause`.
Eigen::Index first_column(const JointFit& fit, std::size_t cause) {
  Eigen::Index column = fit.model.size();
  for (std::size_t k = 0; k < cause; ++k) column += fitted_count(*fit.effects[k].effect);
  return column;
}

}  // namespace

std::vector<Estimate> estimates_of(const JointFit& fit, std::size_t cause) {
  std::vector<Estimate> result;
  Eigen::Index column = first_column(fit, cause);
  const ActiveEffect& active = fit.effects[cause];
  for (std::size_t i = 0; i < active.x.size(); ++i) {
    const auto parameter =
        simulation::parameter_at(*active.effect, active.place, static_cast<int>(i));
    const bool fitted = static_cast<int>(i) < fitted_count(*active.effect);
    // Either the place lacks it (a step in a joint has no y) or no reading moves with it.
    if (!parameter || (fitted && fit.J.col(column).squaredNorm() <= 0)) {
      if (fitted) ++column;
      continue;
    }
    result.push_back(
        {std::string(parameter->name), std::string(parameter->unit), active.x[i],
         fitted ? std::sqrt(std::max(0.0, fit.covariance(column, column))) : kNan});
    if (fitted) ++column;
  }
  return result;
}

double visible_ratio(const Readings& readings, const JointFit& fit, std::size_t cause) {
  Eigen::Index column = first_column(fit, cause);
  const ActiveEffect& active = fit.effects[cause];
  const int own = fitted_count(*active.effect);
  Eigen::MatrixXd others(fit.J.rows(), fit.J.cols() - own);
  others << fit.J.leftCols(column), fit.J.rightCols(fit.J.cols() - column - own);
  const Eigen::VectorXd root = fit.root();
  Eigen::VectorXd does = Eigen::VectorXd::Zero(fit.J.rows());
  for (int i = 0; i < linear_count(*active.effect); ++i) {
    does += fit.J.col(column + i) * active.x[static_cast<std::size_t>(i)];
  }
  does = root.cwiseProduct(does);
  const Eigen::MatrixXd Q = orthonormal_basis(root.asDiagonal() * others);
  does -= Q * (Q.transpose() * does);
  return does.norm() / std::sqrt(static_cast<double>(readings.count())) /
         std::max(1e-12, fit.s_mm);
}

}  // namespace sixdial::diagnosis
