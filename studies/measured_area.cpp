#include "studies/measured_area.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/tool.h"
#include "studies/compensate.h"
#include "studies/plausibility.h"

namespace sixdial::studies {
namespace {

using geometry::Position;

/// Twice the area of the triangle, positive where the turn is to the left.
double turn(const Position& a, const Position& b, const Position& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Counter-clockwise (A. M. Andrew's monotone chain).
std::vector<Position> convex_hull(std::vector<Position> points) {
  std::ranges::sort(points, [](const Position& a, const Position& b) {
    return std::pair(a[0], a[1]) < std::pair(b[0], b[1]);
  });
  std::vector<Position> hull;
  const auto half = [&](auto first, auto last) {
    const std::size_t begin = hull.size();
    for (; first != last; ++first) {
      while (hull.size() >= begin + 2 &&
             turn(hull[hull.size() - 2], hull.back(), *first) <= 0) {
        hull.pop_back();
      }
      hull.push_back(*first);
    }
    hull.pop_back();  // the other half begins with it
  };
  if (points.size() < 2) return points;
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return hull;
}

double distance_to_edge_mm(const Position& a, const Position& b, const Position& p) {
  const Position along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double median_spacing_mm(const std::vector<Position>& points) {
  constexpr double kSamePlace_mm = 0.01;    // a repeat
  constexpr std::size_t kMostLooked = 500;  // the spacing of these tells enough
  const std::size_t step = std::max<std::size_t>(1, points.size() / kMostLooked);
  std::vector<double> nearest;
  for (std::size_t i = 0; i < points.size(); i += step) {
    double least = std::numeric_limits<double>::infinity();
    for (const Position& other : points) {
      const double apart = (other - points[i]).norm();
      if (apart > kSamePlace_mm) least = std::min(least, apart);
    }
    if (std::isfinite(least)) nearest.push_back(least);
  }
  if (nearest.empty()) return 0.0;
  const auto middle = nearest.begin() + std::ssize(nearest) / 2;
  std::ranges::nth_element(nearest, middle);
  return *middle;
}

}  // namespace

MeasuredArea::MeasuredArea(const session::Session& session) {
  const geometry::Tool tool(session.rig);
  const bool has_g1 = std::ranges::any_of(session.samples, [](const session::Sample& sample) {
    return !sample.left_out && sample.set == "G1";
  });
  std::vector<Position> points;
  for (const session::Sample& sample : session.samples) {
    if (sample.left_out || (has_g1 && sample.set != "G1")) continue;
    std::optional<Position> place = sample.target_mm;
    if (!place) {
      const auto nominal =
          tool.position(session.rig.robot.nominal, sample.q, session.rig.robot.assembly);
      if (!nominal) continue;
      place = *nominal;
    }
    points.push_back(*place);
    const geometry::WorkingMode mode = mode_of(session.rig, sample.q, *place);
    if (!has_mode(mode)) modes_.push_back(mode);
  }
  if (points.empty()) return;
  spacing_mm_ = median_spacing_mm(points);
  if (points.front().size() == 2) {
    outline_ = convex_hull(std::move(points));
    return;
  }
  Position least = points.front();
  Position most = points.front();
  for (const Position& point : points) {
    least = least.cwiseMin(point);
    most = most.cwiseMax(point);
  }
  outline_ = {least, most};
}

bool MeasuredArea::has_mode(geometry::WorkingMode mode) const {
  return std::ranges::find(modes_, mode) != modes_.end();
}

double MeasuredArea::outside_mm(const Position& p_WE) const {
  if (outline_.empty() || p_WE.size() != outline_.front().size()) return 0.0;
  const double beyond_mm = p_WE.size() == 2 ? beyond_hull_mm(p_WE) : beyond_box_mm(p_WE);
  return beyond_mm > spacing_mm_ ? beyond_mm : 0.0;
}

double MeasuredArea::beyond_hull_mm(const Position& p_WE) const {
  bool inside = outline_.size() >= 3;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < outline_.size(); ++i) {
    const Position& a = outline_[i];
    const Position& b = outline_[(i + 1) % outline_.size()];
    inside = inside && turn(a, b, p_WE) >= 0;
    nearest = std::min(nearest, distance_to_edge_mm(a, b, p_WE));
  }
  return inside ? 0.0 : nearest;
}

double MeasuredArea::beyond_box_mm(const Position& p_WE) const {
  return (p_WE - p_WE.cwiseMax(outline_[0]).cwiseMin(outline_[1])).norm();
}

MeasuredArea measured_area(const session::Session& session) {
  return MeasuredArea(in_rig_frame(plausible(session), session.rig));
}

OutsideMeasured outside_measured(
    const MeasuredArea& area, const geometry::Position& target_mm, geometry::WorkingMode mode) {
  const double outside_mm = area.outside_mm(target_mm);
  return {
      .farthest_mm = outside_mm,
      .points = outside_mm > 0 ? 1 : 0,
      .points_of_new_mode = area.has_mode(mode) ? 0 : 1};
}

OutsideMeasured outside_measured(
    const MeasuredArea& area, const session::Plan& plan, const geometry::Rig& rig) {
  OutsideMeasured all;
  for (const session::PlanPoint& point : plan.points) {
    const OutsideMeasured one =
        outside_measured(area, point.target_mm, mode_of(rig, point.q, point.target_mm));
    all.farthest_mm = std::max(all.farthest_mm, one.farthest_mm);
    all.points += one.points;
    all.points_of_new_mode += one.points_of_new_mode;
  }
  return all;
}

}  // namespace sixdial::studies
