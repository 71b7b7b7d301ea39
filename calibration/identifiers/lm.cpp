// Levenberg-Marquardt on all samples: the reference minimum. With a robust loss on request.
#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

Identified fit(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  LeastSquaresSettings core = core_settings(space, settings);
  core.loss_scale = 0.0;  // from the residuals
  LeastSquaresFit found = solve_robustly(
      space.problem(weighting_of(space, settings)), space.nominal, core, settings.loss,
      space.block());
  Identified result;
  result.x = found.x;
  result.status = found.status;
  result.iterations = found.iterations;
  return result;
}

}  // namespace

extern constinit const Identifier lm{
    .name = "lm",
    .title = "least squares (LM)",
    .description = "Levenberg-Marquardt, nonlinear least squares",
    .identify = fit};

}  // namespace sixdial::calibration
