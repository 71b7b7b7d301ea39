// The filter with Q = R = 1e-4 I.
#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

Identified filter(
    const ObservationSpace& space, const IdentifySettings& settings, const SearchProgress&,
    const std::stop_token&) {
  const int n = space.parameters();
  Eigen::VectorXd q = Eigen::VectorXd::Constant(n, settings.first_variance);
  Eigen::VectorXd p0 = Eigen::VectorXd::Constant(n, settings.p0);
  for (int i = 0; i < n; ++i) {
    if (is_fixed(settings, i)) q[i] = p0[i] = 0.0;
  }
  const Eigen::VectorXd r = Eigen::VectorXd::Constant(space.channels, settings.first_variance);
  Identified result;
  result.x = space.nominal +
             filter_space(space, q, r, p0, settings.linearisation, &result.unit_covariance);
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
