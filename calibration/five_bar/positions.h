// What the position methods fit: joint angles and where the tool was measured, sample by
// sample. Made from Trials, of which only those with a position count (the rest serve the dial
// space).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "geometry/robots/five_bar.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

/// Column i of each matrix is one sample. Lengths mm, angles rad, frame W.
struct PositionObservations {
  Eigen::Matrix2Xd q_rad;  // encoder angles
  Eigen::Matrix2Xd p_WE;   // measured tool positions
  std::vector<geometry::Assembly> assembly;
  std::vector<Eigen::Matrix2d> covariance_mm2;  // zero where nobody knows
  std::vector<std::optional<Eigen::Vector2d>> target_mm;
  std::vector<int> sample;  // row in the session
  std::vector<int> point;
  std::vector<int> repeat;

  [[nodiscard]] int size() const { return static_cast<int>(q_rad.cols()); }
  [[nodiscard]] bool empty() const { return size() == 0; }
  /// The chosen samples, in the order given.
  [[nodiscard]] PositionObservations subset(std::span<const int> indices) const;
};

/// Samples without a position, or with a number that is not finite, are left out.
[[nodiscard]] PositionObservations position_observations(
    std::span<const simulation::Trial> trials);

}  // namespace sixdial::calibration
