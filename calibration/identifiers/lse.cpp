// Linear least squares, equation (16): f and J at the nominal parameters, once; and the same
// again and again at what was found (Gauss-Newton).
#include <cmath>

#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

constexpr int kMostSteps = 50;
constexpr double kSettled = 1e-12;  // step in units of scale

Identified steps(const ObservationSpace& space, const IdentifySettings& settings, int most) {
  Identified result;
  result.x = space.nominal;
  const LeastSquaresProblem problem = space.problem(weighting_of(space, settings));
  LeastSquaresSettings core = core_settings(space, settings);
  core.max_iterations = 0;
  result.status = most > 1 ? FitStatus::kIterationLimit : FitStatus::kConverged;
  for (int k = 0; k < most; ++k) {
    // Singular values of the weighted J at x; held directions get no step.
    const LeastSquaresFit at = solve_least_squares(problem, result.x, core);
    if (at.status == FitStatus::kBadStart) {
      result.status = at.status;
      return result;
    }
    const Eigen::VectorXd step = -at.unit_covariance() * (at.J.transpose() * at.residual);
    result.x += step;
    if (most == 1) result.unit_covariance = at.unit_covariance();
    ++result.iterations;
    if (step.cwiseQuotient(space.scale()).norm() < kSettled) {
      result.status = FitStatus::kConverged;
      return result;
    }
  }
  return result;
}

Identified once(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  return steps(space, settings, 1);
}

Identified iterated(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  return steps(space, settings, kMostSteps);
}

}  // namespace

extern constinit const Identifier lse{
    .name = "lse",
    .title = "LSE",
    .description = "linear least squares at nominal, one step (16)",
    .identify = once};
extern constinit const Identifier lse_iterated{
    .name = "lse_iterated",
    .title = "LSE, iterated",
    .description = "linear least squares, repeated until it settles",
    .identify = iterated};

}  // namespace sixdial::calibration
