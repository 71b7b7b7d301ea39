// How well the rig file knows what it says: standard deviations of where things stand and of
// their sizes. Empty: the file does not say, and is read as exact. 0: exact.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace sixdial::geometry {

struct DialDeviations {
  std::optional<Eigen::Vector2d> position_mm;  // along its axis, across it
  std::optional<double> axis_rad;
  std::optional<double> tip_radius_mm;
  friend bool operator==(const DialDeviations&, const DialDeviations&) = default;
};

struct CuboidDeviations {
  std::optional<double> side_mm;
  std::optional<double> squareness_rad;  // of neighbouring faces
  std::optional<double> offset_mm;       // of its centre from the tool, each axis
  friend bool operator==(const CuboidDeviations&, const CuboidDeviations&) = default;
};

}  // namespace sixdial::geometry
