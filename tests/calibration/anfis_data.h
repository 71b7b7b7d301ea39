// Inputs and a smooth error for tests of networks.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "calibration/random.h"

namespace sixdial::calibration {

/// Uniform in [1, 2), samples x inputs.
inline Eigen::MatrixXd random_inputs(int samples, int inputs, std::uint64_t seed) {
  RandomSequence random(seed);
  Eigen::MatrixXd x(samples, inputs);
  for (double& each : x.reshaped()) each = random.uniform(1.0, 2.0);
  return x;
}

/// Of the first and the last input [mm].
inline Eigen::VectorXd smooth(const Eigen::MatrixXd& x) {
  return (0.02 * (3 * x.col(0).array()).sin() + 0.01 * (2 * x.col(x.cols() - 1).array()).cos())
      .matrix();
}

}  // namespace sixdial::calibration
