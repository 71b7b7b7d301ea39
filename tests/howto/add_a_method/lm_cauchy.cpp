// The identifier of CONTRIBUTING.md's "Add a calibration method": Levenberg-Marquardt with a
// Cauchy loss, whatever loss the settings ask for.
#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

Identified fit(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  LeastSquaresSettings core = core_settings(space, settings);
  core.loss_scale = 0.0;  // from the residuals
  LeastSquaresFit found = solve_robustly(
      space.problem(weighting_of(space, settings)), space.nominal, core, Loss::kCauchy,
      space.block());
  Identified result;
  result.x = found.x;
  result.status = found.status;
  result.iterations = found.iterations;
  return result;
}

}  // namespace

extern constinit const Identifier lm_cauchy{
    .name = "lm_cauchy",
    .title = "Lm cauchy",
    .description = "Levenberg-Marquardt, Cauchy loss",
    .identify = fit};

}  // namespace sixdial::calibration
