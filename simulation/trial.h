// One measured sample as the methods see it: numbers only, no file, no clock, no device.
// session/trials.h makes these from a session; calibration/ and diagnosis/ fit and explain
// them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "geometry/five_bar.h"

namespace sixdial::simulation {

struct Trial {
  int sample = 0;  // row in the session it came from
  int point = 0;
  int repeat = 0;
  Eigen::Vector2d q_rad{0, 0};  // encoder angles
  geometry::Assembly assembly =
      geometry::Assembly::kLeft;             // of this pose (modes can be pooled)
  std::optional<Eigen::Vector2d> target_mm;  // in W
  std::optional<double> time_s;              // since the first sample
  std::optional<double> temperature_c;
  std::array<int, 2> approach{0, 0};           // sign of each joint's last move, 0 unknown
  std::vector<std::optional<double>> dial_mm;  // in the order of rig.dials
  /// Position in W [mm]: an instrument's, or the best active three's. Empty: contacts allow
  /// none.
  std::optional<Eigen::Vector2d> position_mm;
  Eigen::Matrix2d position_covariance = Eigen::Matrix2d::Zero();  // [mm^2]
  std::optional<double> gamma_rad;                                // of the active three
  std::array<int, 3> active_dials{-1, -1, -1};  // indices; -1: instrument or none
};

}  // namespace sixdial::simulation
