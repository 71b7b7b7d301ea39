// Where in the workspace the robot will be used, and how well its position is known there for a
// given covariance of the parameters.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/tool.h"

namespace sixdial::calibration {

/// A pose to be used or measured.
struct WorkspacePose {
  geometry::Position target_mm;
  Eigen::VectorXd q;
  geometry::Assembly assembly = geometry::Assembly::kLeft;
  geometry::WorkingMode mode{};
};

/// nx x ny targets of a rectangle (corners low and high [mm], W; halfway between them in z) in
/// each mode; those that the parameters cannot reach are left out.
[[nodiscard]] std::vector<WorkspacePose> workspace_grid(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const geometry::Position& low_mm,
    const geometry::Position& high_mm, int nx, int ny,
    std::span<const geometry::WorkingMode> modes);

/// Standard deviation of the modelled position, root of the trace of J P J' [mm], over poses.
struct WorkspaceUncertainty {
  double mean_mm = 0.0;
  double max_mm = 0.0;
  double rms_mm = 0.0;
  std::size_t worst = 0;  // pose of the maximum
  std::size_t poses = 0;  // that v reaches
};
[[nodiscard]] WorkspaceUncertainty workspace_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& P,
    std::span<const WorkspacePose> poses);

/// The same at one pose; NaN where v cannot reach it.
[[nodiscard]] double position_sd_mm(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& P,
    const WorkspacePose& pose);

}  // namespace sixdial::calibration
