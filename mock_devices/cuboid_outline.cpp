#include "mock_devices/cuboid_outline.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr double kClosed_mm = 1e-13;
constexpr int kMostSteps = 60;

Vector2d turned_left(const Vector2d& a) { return {-a.y(), a.x()}; }

}  // namespace

CuboidOutline::CuboidOutline(
    const Vector2d& centre_W, double gamma_rad, double side_mm, double shear_rad) {
  const double half = side_mm / 2;
  const Vector2d n(std::cos(gamma_rad), std::sin(gamma_rad));
  const double second = gamma_rad + std::numbers::pi / 2 + shear_rad;
  const Vector2d m(std::cos(second), std::sin(second));
  normal_ = {n, m, -n, -m};
  for (std::size_t k = 0; k < 4; ++k) {
    // The corner of sides k and k + 1: a . n = half and a . m = half by Cramer's rule.
    const Vector2d& first = normal_[k];
    const Vector2d& next = normal_[(k + 1) % 4];
    const double det = first.x() * next.y() - first.y() * next.x();
    corner_[k] = centre_W + Vector2d(next.y() - first.y(), first.x() - next.x()) * (half / det);
  }
  for (std::size_t k = 0; k < 4; ++k) {
    along_[k] = turned_left(normal_[k]);
    length_[k] = (corner_[k] - corner_[(k + 3) % 4]).norm();
  }
}

CuboidOutline::Distance CuboidOutline::distance(const Vector2d& p_W) const {
  Distance best{std::numeric_limits<double>::infinity(), Vector2d::Zero(), false};
  Distance deepest{-std::numeric_limits<double>::infinity(), Vector2d::Zero(), false};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector2d from_start = p_W - corner_[(k + 3) % 4];
    const double height = from_start.dot(normal_[k]);
    if (height > deepest.mm) deepest = {height, normal_[k], false};
    if (height <= 0.0) continue;
    const double s = from_start.dot(along_[k]);
    if (s >= 0.0 && s <= length_[k]) {
      if (height < best.mm) best = {height, normal_[k], false};
      continue;
    }
    const Vector2d from_corner = s < 0.0 ? from_start : Vector2d(p_W - corner_[k]);
    const double away = from_corner.norm();
    if (away < best.mm) best = {away, from_corner / away, true};
  }
  return deepest.mm <= 0.0 ? deepest : best;
}

std::optional<Push> push_of(
    const CuboidOutline& outline, const Plunger& plunger, double travel_mm) {
  const Vector2d ball_at_zero = plunger.tip_front_mm - plunger.tip_radius_mm * plunger.axis;
  const auto at = [&](double displacement) {
    return outline.distance(ball_at_zero - displacement * plunger.axis);
  };
  // The gap is convex in the displacement: from far out, Newton's steps walk in to the outer
  // touching point and never pass it; a slope that is not positive means the ball passes by.
  double displacement = 2 * travel_mm;
  CuboidOutline::Distance here = at(displacement);
  while (here.mm <= plunger.tip_radius_mm) {  // the cuboid covers the dial's whole body
    displacement *= 2;
    if (displacement > 1e6) return std::nullopt;
    here = at(displacement);
  }
  for (int step = 0; step < kMostSteps; ++step) {
    const double slope = -here.gradient.dot(plunger.axis);
    if (slope <= 1e-9) return std::nullopt;
    const double change = (here.mm - plunger.tip_radius_mm) / slope;
    displacement -= change;
    if (displacement < -1e3 * travel_mm) return std::nullopt;
    here = at(displacement);
    if (std::abs(change) < kClosed_mm) break;
  }
  const double slope = -here.gradient.dot(plunger.axis);
  if (displacement <= 0.0 || slope <= 1e-9) return std::nullopt;
  return Push{displacement, here.on_corner, here.gradient / slope};
}

}  // namespace sixdial::mock_devices
