// The filter with Q = R = 1e-4 I.
#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

Identified filter(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  const int n = space.parameters();
  FilterSettings filter;
  filter.linearisation = settings.linearisation;
  filter.p0 = diagonal_of({}, n, settings.p0, settings.fixed);
  filter.noise.q = diagonal_of({}, n, settings.first_variance, settings.fixed);
  filter.noise.r = diagonal_of({}, space.channels(), settings.first_variance);
  Identified result;
  result.x = space.nominal + filter_errors(space, filter, &result.unit_covariance);
  result.iterations = space.samples();
  if (!result.x.allFinite()) {
    result.status = FitStatus::kBadStart;
    result.x = space.nominal;
    result.unit_covariance.resize(0, 0);
  }
  return result;
}

}  // namespace

extern constinit const Identifier ekf{
    .name = "ekf",
    .title = "EKF",
    .description = "extended Kalman filter, Q = R = 1e-4 (17)-(22)",
    .identify = filter};

}  // namespace sixdial::calibration
