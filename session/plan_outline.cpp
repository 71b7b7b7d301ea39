#include "session/plan_outline.h"

#include <cmath>
#include <numbers>
#include <set>

namespace sixdial::session {

Plan outermost(const geometry::Rig& rig, const Plan& plan) {
  constexpr int kDirections = 8;
  std::set<std::size_t> chosen;
  for (const Stretch& stretch : stretches_of(rig, plan)) {
    for (int k = 0; k < kDirections; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / kDirections;
      std::size_t farthest = stretch.first;
      double most_mm = -1e300;
      for (std::size_t i = stretch.first; i < stretch.first + stretch.points; ++i) {
        const Position& target_mm = plan.points[i].target_mm;
        const double out_mm =
            std::cos(angle_rad) * target_mm[0] + std::sin(angle_rad) * target_mm[1];
        if (out_mm <= most_mm) continue;
        most_mm = out_mm;
        farthest = i;
      }
      chosen.insert(farthest);
    }
  }
  Plan result;
  for (const std::size_t i : chosen) result.points.push_back(plan.points[i]);
  return result;
}

}  // namespace sixdial::session
