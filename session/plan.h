// What to measure: the planned points of a session, as a CSV file people can edit.
// Columns: set,point,repeat,target_x_mm,target_y_mm,theta1_rad,theta2_rad,approach1,approach2.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/rig.h"

namespace sixdial::session {

struct PlanPoint {
  std::string set;
  int point = 0;
  int repeat = 0;
  Eigen::Vector2d target_mm{0, 0};    // in W
  Eigen::Vector2d q_rad{0, 0};        // joint angles to command, by nominal parameters
  std::array<int, 2> approach{0, 0};  // sign of each joint's last move; 0: as it comes
};

struct Plan {
  std::vector<PlanPoint> points;
};

}  // namespace sixdial::session
