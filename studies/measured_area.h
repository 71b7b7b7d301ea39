// Where a session was measured: its convex hull in the plane (a box in space) and its working
// modes. Parameters found there say less elsewhere, and learned residuals nothing.
//
// Example:
//   const MeasuredArea area(session);
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
  /// Of the samples of G1, which are fitted; of all where there is no G1.
  explicit MeasuredArea(const session::Session& session);
  /// How far outside a place is; 0 up to one usual spacing of the points (median way to the
  /// nearest neighbour) beyond the outermost ones. 0 as well where nothing was measured.
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
