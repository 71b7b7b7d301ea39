#include "calibration/position_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <memory>

#include "calibration/position_kernel.h"

namespace sixdial::calibration {
namespace {

/// W with W'W = C^-1 times the mean variance, so weighted residuals stay in mm.
std::vector<Eigen::Matrix2d> whitening(const PositionObservations& observations) {
  double mean_variance = 0.0;
  for (const Eigen::Matrix2d& C : observations.covariance_mm2) mean_variance += C.trace() / 2;
  mean_variance /= std::max(observations.size(), 1);
  std::vector<Eigen::Matrix2d> result;
  for (const Eigen::Matrix2d& C : observations.covariance_mm2) {
    const Eigen::LLT<Eigen::Matrix2d> llt(C);
    if (llt.info() == Eigen::Success && C.determinant() > 0.0) {
      result.push_back(
          std::sqrt(mean_variance) * llt.matrixL().solve(Eigen::Matrix2d::Identity()).eval());
    } else {
      result.push_back(Eigen::Matrix2d::Identity());
    }
  }
  return result;
}

}  // namespace

geometry::ParameterVector parameter_scale() {
  geometry::ParameterVector scale = geometry::ParameterVector::Ones();
  scale.tail<3>().setConstant(1.0 / 60.0);
  return scale;
}

LeastSquaresProblem position_problem(
    const PositionObservations& observations, bool weigh_by_covariance) {
  auto weights = weigh_by_covariance
                     ? std::make_shared<std::vector<Eigen::Matrix2d>>(whitening(observations))
                     : nullptr;
  LeastSquaresProblem problem;
  problem.parameters = geometry::kParameterCount;
  problem.residuals = 2 * observations.size();
  problem.evaluate = [&observations, weights](
                         const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd* J) {
    const geometry::ParameterVector v = x;
    for (int i = 0; i < observations.size(); ++i) {
      const Eigen::Vector2d q = observations.q_rad.col(i);
      const auto k = static_cast<std::size_t>(i);
      if (J == nullptr) {
        const auto pose = geometry::forward(v, q, observations.assembly[k]);
        if (!pose) return false;
        r.segment<2>(2 * i) = pose->p_WE - observations.p_WE.col(i);
      } else {
        const auto d = geometry::forward_derivative(v, q, observations.assembly[k]);
        if (!d) return false;
        r.segment<2>(2 * i) = d->pose.p_WE - observations.p_WE.col(i);
        J->middleRows<2>(2 * i) = d->J_v;
      }
      if (weights) {
        r.segment<2>(2 * i) = ((*weights)[k] * r.segment<2>(2 * i)).eval();
        if (J != nullptr) {
          J->middleRows<2>(2 * i) = ((*weights)[k] * J->middleRows<2>(2 * i)).eval();
        }
      }
    }
    return true;
  };
  if (!weigh_by_covariance) {
    auto blocks =
        std::make_shared<const std::vector<PositionBlock>>(position_blocks(observations));
    problem.normal = [blocks](
                         const Eigen::VectorXd& x, Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr,
                         double& rss) { return position_normal(*blocks, x, JtJ, Jtr, rss); };
  }
  return problem;
}

namespace {

PositionFit run(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    geometry::ParameterVector start, const PositionFitSettings& settings, int max_iterations) {
  LeastSquaresSettings core;
  core.max_iterations = max_iterations;
  core.first_damping = 1e-7;  // nominal is near; condition 400
  core.scale = parameter_scale();
  core.anchor = nominal;
  core.hold_below = settings.noise_mm / settings.hold_uncertainty_mm;
  core.loss_scale = settings.loss_scale_mm;
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const bool fixed = settings.fixed[static_cast<std::size_t>(i)];
    core.fixed.push_back(fixed ? 1 : 0);
    if (fixed) start[i] = nominal[i];
  }
  PositionFit result;
  result.fit = solve_robustly(
      position_problem(observations, settings.weigh_by_covariance), start, core, settings.loss,
      2);
  result.v = result.fit.x;
  const bool known = result.fit.status != FitStatus::kBadStart &&
                     !settings.weigh_by_covariance && !observations.empty();
  result.rmse_mm = known ? std::sqrt(result.fit.rss / observations.size())
                         : position_rmse(observations, result.v);
  if (result.fit.status == FitStatus::kBadStart) return result;
  result.sigma_mm = std::sqrt(result.fit.variance());
  const double variance =
      result.sigma_mm > 0.0 ? result.fit.variance() : settings.noise_mm * settings.noise_mm;
  result.covariance = variance * result.fit.unit_covariance();
  return result;
}

}  // namespace

PositionFit fit_positions(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const PositionFitSettings& settings) {
  return run(
      observations, nominal, settings.start.value_or(nominal), settings,
      LeastSquaresSettings{}.max_iterations);
}

PositionFit assess_positions(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const geometry::ParameterVector& v, const PositionFitSettings& settings) {
  return run(observations, nominal, v, settings, 0);
}

}  // namespace sixdial::calibration
