// The paper's kinematic calibration: the filter tuned by QPSO-1, then the parameters by QPSO-2.
#include "calibration/identifier.h"

namespace sixdial::calibration {
namespace {

Identified search(
    const ObservationSpace& space, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop) {
  const Identified tuned = qpso1_in(space, settings, progress, stop);
  if (tuned.cancelled || !tuned.x.allFinite()) return tuned;
  return qpso2_in(space, tuned.x, settings, progress, stop);
}

}  // namespace

extern constinit const Identifier ekf_dqpso{
    .name = "ekf_dqpso",
    .title = "EKF-DQPSO",
    .description = "filter tuned by QPSO-1, parameters by QPSO-2 (29), (31)",
    .identify = search};

}  // namespace sixdial::calibration
