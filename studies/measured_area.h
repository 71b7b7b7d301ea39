// Where a session was measured: the convex hull (in space: the box) of its targets, or of the
// nominal robot's places where there are none, and its working modes. Parameters found there
// say less elsewhere, and learned residuals nothing.
//
// Example:
//   const MeasuredArea area = measured_area(session);
//   area.outside_mm(*session.samples.front().target_mm);  // -> 0.0
//   area.outside_mm(Eigen::Vector2d(500.0, 500.0)) > 100.0;  // -> true
#pragma once

#include <vector>

#include "geometry/pose.h"
#include "geometry/rig.h"
#include "session/plan.h"
#include "session/session.h"

namespace sixdial::studies {

class MeasuredArea {
 public:
  /// Of the samples of G1, which are fitted; of all where there is no G1. Those that are left
  /// out do not count.
  explicit MeasuredArea(const session::Session& session);
  /// How far outside a place is. Up to one usual spacing of the points (median way to the
  /// nearest neighbour) beyond the outermost ones it counts as inside: 0. Farther out the whole
  /// way to them. 0 as well where nothing was measured.
  [[nodiscard]] double outside_mm(const geometry::Position& p_WE) const;
  [[nodiscard]] bool has_mode(geometry::WorkingMode mode) const;

 private:
  [[nodiscard]] double beyond_hull_mm(const geometry::Position& p_WE) const;
  [[nodiscard]] double beyond_box_mm(const geometry::Position& p_WE) const;

  std::vector<geometry::Position>
      outline_;  // hull, counter-clockwise; of a box its two corners
  std::vector<geometry::WorkingMode> modes_;
  double spacing_mm_ = 0.0;
};

/// Of a session as it was read: without the rows that plausible() leaves out, in the rig file's
/// frame.
[[nodiscard]] MeasuredArea measured_area(const session::Session& session);

/// What lies outside of what was measured.
struct OutsideMeasured {
  double farthest_mm = 0.0;    // 0: every target is inside
  int points = 0;              // so many targets are outside
  int points_of_new_mode = 0;  // so many are in a working mode without a sample
};
[[nodiscard]] OutsideMeasured outside_measured(
    const MeasuredArea& area, const geometry::Position& target_mm, geometry::WorkingMode mode);
[[nodiscard]] OutsideMeasured outside_measured(
    const MeasuredArea& area, const session::Plan& plan, const geometry::Rig& rig);

}  // namespace sixdial::studies
