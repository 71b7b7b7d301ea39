// One measured sample as the methods see it: numbers only, no file, no clock, no device.
// session/trials.h makes these from a session; calibration/ and diagnosis/ fit and explain
// them. Joints are in the order of the robot's joints, channels in that of the instrument's.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/robot_kind.h"

namespace sixdial::simulation {

struct Trial {
  int sample = 0;  // row in the session it came from
  int point = 0;
  int repeat = 0;
  Eigen::VectorXd q;  // what the encoders read, joint by joint [rad, or mm of a prismatic one]
  geometry::Assembly assembly =
      geometry::Assembly::kLeft;             // of this pose (modes can be pooled)
  std::optional<Eigen::VectorXd> target_mm;  // in W, as many as the position has
  std::optional<double> time_s;              // since the first sample
  std::optional<double> temperature_c;
  std::vector<int> approach;  // by joint: sign of its last move, 0 unknown; empty: all unknown
  std::vector<std::optional<double>> reading;  // by channel of the instrument
  /// Position in W [mm], 2 or 3 numbers: measured as such, or computed from the readings (best
  /// active three dials). Empty: the readings allow none.
  std::optional<Eigen::VectorXd> position_mm;
  Eigen::MatrixXd position_covariance;  // [mm^2]; 0 x 0: nobody knows it
  std::optional<double> gamma_rad;      // the cuboid's rotation, as computed with the position
  std::vector<int> position_channels;   // that it was computed from; empty: measured as such

  /// Sign of a joint's last move, 0 unknown.
  [[nodiscard]] int approach_of(std::size_t joint) const {
    return joint < approach.size() ? approach[joint] : 0;
  }
  /// position_covariance, zero where nobody knows it: as many rows as the position has.
  [[nodiscard]] Eigen::MatrixXd covariance_or_zero() const {
    if (position_covariance.size() > 0 || !position_mm) return position_covariance;
    return Eigen::MatrixXd::Zero(position_mm->size(), position_mm->size());
  }
};

}  // namespace sixdial::simulation
