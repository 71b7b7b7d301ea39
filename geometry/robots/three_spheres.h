// The point at given distances from three others, for any number type: what a delta's platform
// does.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>

namespace sixdial::geometry {

/// side +1: the solution below the plane of the centres (less z); -1: the one above it. Empty
/// where the spheres do not meet, or the centres lie on a line.
template <typename T>
std::optional<Eigen::Matrix<T, 3, 1>> three_spheres(
    const std::array<Eigen::Matrix<T, 3, 1>, 3>& centre, const std::array<T, 3>& radius,
    int side) {
  using std::sqrt;
  using Vector = Eigen::Matrix<T, 3, 1>;
  const Vector ab = centre[1] - centre[0];
  const Vector ac = centre[2] - centre[0];
  const T length = sqrt(ab.dot(ab));
  if (!(length > T(0.0))) return std::nullopt;
  const Vector ex = ab / length;
  const T i = ex.dot(ac);
  const Vector across = ac - ex * i;
  const T j = sqrt(across.dot(across));
  if (!(j > T(1e-9) * length)) return std::nullopt;
  const Vector ey = across / j;
  const Vector ez = ex.cross(ey);
  const T x =
      (radius[0] * radius[0] - radius[1] * radius[1] + length * length) / (T(2.0) * length);
  const T y = (radius[0] * radius[0] - radius[2] * radius[2] + i * i + j * j - T(2.0) * i * x) /
              (T(2.0) * j);
  const T z2 = radius[0] * radius[0] - x * x - y * y;
  // Stretched flat: the place exists, its derivative does not.
  if (!(z2 > T(1e-12) * radius[0] * radius[0])) return std::nullopt;
  const T z = sqrt(z2);
  const double up = ez.z() < T(0.0) ? -1.0 : 1.0;
  return Vector(centre[0] + ex * x + ey * y - ez * (T(up * static_cast<double>(side)) * z));
}

}  // namespace sixdial::geometry
