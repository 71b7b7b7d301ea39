#include "calibration/space_fit.h"

#include <cmath>

namespace sixdial::calibration {
namespace {

SpaceFit run(
    const ObservationSpace& space, Eigen::VectorXd start, const SpaceFitSettings& settings,
    int max_iterations) {
  LeastSquaresSettings core;
  core.max_iterations = max_iterations;
  core.first_damping = 1e-7;  // nominal is near; condition 400
  core.scale = space.scale();
  core.anchor = space.nominal;
  core.hold_below = settings.noise_mm / settings.hold_uncertainty_mm;
  core.loss_scale = settings.loss_scale_mm;
  for (int i = 0; i < space.parameters(); ++i) {
    const bool fixed = is_fixed(settings.fixed, i);
    core.fixed.push_back(fixed ? 1 : 0);
    if (fixed) start[i] = space.nominal[i];
  }
  SpaceFit result;
  result.fit = solve_robustly(
      space.problem(settings.weighting), start, core, settings.loss, space.block());
  result.v = result.fit.x;
  const bool known = result.fit.status != FitStatus::kBadStart &&
                     settings.weighting == Weighting::kAlike && space.samples() > 0;
  result.rmse_mm = known ? std::sqrt(result.fit.rss / space.samples()) : space.rmse(result.v);
  result.covariance = Eigen::MatrixXd::Zero(space.parameters(), space.parameters());
  if (result.fit.status == FitStatus::kBadStart) return result;
  result.sigma_mm = std::sqrt(result.fit.variance());
  const double variance =
      result.sigma_mm > 0.0 ? result.fit.variance() : settings.noise_mm * settings.noise_mm;
  result.covariance = variance * result.fit.unit_covariance();
  return result;
}

}  // namespace

SpaceFit fit_space(const ObservationSpace& space, const SpaceFitSettings& settings) {
  return run(
      space, settings.start.value_or(space.nominal), settings,
      LeastSquaresSettings{}.max_iterations);
}

SpaceFit assess_space(
    const ObservationSpace& space, const Eigen::VectorXd& v, const SpaceFitSettings& settings) {
  return run(space, v, settings, 0);
}

}  // namespace sixdial::calibration
