// A robot that no part of the program knows: three joints, five parameters, positions in space.
// Whatever runs on it does not count on the five-bar.
//
//   r = a cos(s) + b cos(s + e),  z = h + a sin(s) + b sin(s + e),  x = r cos q1, y = r sin q1
//   with s = q2 + shoulder, e = q3 + elbow
#pragma once

#include <cstdint>

#include "calibration/observation_space.h"

namespace sixdial::calibration::testing {

struct SpatialArm {
  ObservationSpace g1, g2;
  Eigen::VectorXd truth;
};

/// `noise_mm`: standard deviation of each axis. `bend_mm`: amplitude of a smooth error of
/// position that no parameter explains.
[[nodiscard]] SpatialArm measured_arm(
    std::uint64_t seed, double noise_mm = 0.003, double bend_mm = 0.0, int points = 80);

}  // namespace sixdial::calibration::testing
