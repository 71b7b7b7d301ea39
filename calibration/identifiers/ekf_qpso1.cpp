// The filter with Q and R found by QPSO-1.
#include "calibration/identifier.h"

namespace sixdial::calibration {

extern constinit const Identifier ekf_qpso1{
    .name = "ekf_qpso1",
    .title = "EKF-QPSO-1",
    .description = "extended Kalman filter, Q and R by QPSO-1 (29)",
    .identify = qpso1_in};

}  // namespace sixdial::calibration
