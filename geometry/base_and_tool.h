// Where an arm stands and where on its last link the measured point sits, from nominal poses of
// the last link and measured places, from any start: closed form for the base at several tools,
// then Newton's steps for both; rows that stand out do not count.
//
//   measured = X (p + R tool)
//
// Degenerate: links that do not turn in at least two directions say nothing of the tool along
// one of them: it then stays small there.
//
// Example:
//   std::vector<Pose<double>> poses(8);  // X_BL of the last link, by the nominal robot
//   Eigen::MatrixXd measured_mm(3, 8);
//   for (int i = 0; i < 8; ++i) {
//     poses[i].p = Eigen::Vector3d(100.0 * (i % 2), 80.0 * (i % 3), 60.0 * (i % 5));
//     measured_mm.col(i) = poses[i].p + Eigen::Vector3d(10, 0, 500);
//   }
//   const auto found = register_base_and_tool(poses, measured_mm);
//   found->median < 1e-6;  // -> true
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "geometry/pose.h"
#include "geometry/registration.h"

namespace sixdial::geometry {

struct BaseAndTool {
  Similarity base;                   // a turn and a shift
  Eigen::Vector3d tool_mm{0, 0, 0};  // in the last link's frame
  double median = 0.0;               // distance of all points [mm]
};

/// `measured_mm`: 3 x poses. Empty: fewer than six points, or points that tell no turn.
[[nodiscard]] std::optional<BaseAndTool> register_base_and_tool(
    std::span<const Pose<double>> poses, const Eigen::MatrixXd& measured_mm);

}  // namespace sixdial::geometry
