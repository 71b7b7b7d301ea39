// A smooth function of one number as a sum of sines on a box that is wider than the range of
// that number, as `joint_curve` bends a joint by. Beyond the range it stays as at the end.
//
//   c(a) = sum over j of c_j sin((u + h) pi (j + 1) / 2h) / sqrt(h),   u in [-1, 1] over the
//   range
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace sixdial::simulation {

/// The numbers before the coefficients: ends of the range, and h.
inline constexpr std::size_t kSmoothHead = 3;

/// Sine number j at u, of a box of half width h.
[[nodiscard]] inline double box_sine(double u, double h, int j) {
  return std::sin((u + h) * (std::numbers::pi * (j + 1) / (2 * h))) / std::sqrt(h);
}

/// `x`: low, high, h, then c_0, c_1, ...; without any coefficient 0.
[[nodiscard]] inline double smooth_value(std::span<const double> x, double at) {
  if (x.size() <= kSmoothHead) return 0.0;
  const double middle = (x[0] + x[1]) / 2;
  const double half = (x[1] - x[0]) / 2;
  const double u = std::clamp((at - middle) / half, -1.0, 1.0);
  double sum = 0.0;
  for (std::size_t j = kSmoothHead; j < x.size(); ++j) {
    if (x[j] == 0.0) continue;
    sum += x[j] * box_sine(u, x[2], static_cast<int>(j - kSmoothHead));
  }
  return sum;
}

}  // namespace sixdial::simulation
