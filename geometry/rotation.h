// Turns in space for any number type: rotation vectors, and turns about one axis.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace sixdial::geometry {

/// The cross product as a matrix: skew(a) b = a x b.
template <typename T>
Eigen::Matrix<T, 3, 3> skew(const Eigen::Matrix<T, 3, 1>& a) {
  Eigen::Matrix<T, 3, 3> S;
  S << T(0.0), -a[2], a[1], a[2], T(0.0), -a[0], -a[1], a[0], T(0.0);
  return S;
}

/// R of a rotation vector (axis times angle). Its derivative exists below a whole turn.
template <typename T>
Eigen::Matrix<T, 3, 3> turned_by(const Eigen::Matrix<T, 3, 1>& w) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T t = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
  T sine_part;    // sin(angle) / angle
  T cosine_part;  // (1 - cos(angle)) / angle^2
  if (t < T(1e-2)) {
    sine_part = T(1.0) - t * (T(1.0 / 6) -
                              t * (T(1.0 / 120) - t * (T(1.0 / 5040) - t * T(1.0 / 362880))));
    cosine_part =
        T(0.5) -
        t * (T(1.0 / 24) - t * (T(1.0 / 720) - t * (T(1.0 / 40320) - t * T(1.0 / 3628800))));
  } else {
    const T angle = sqrt(t);
    sine_part = sin(angle) / angle;
    cosine_part = (T(1.0) - cos(angle)) / t;
  }
  // I + s [w] + c [w]^2, with [w]^2 = w w' - |w|^2 I.
  Eigen::Matrix<T, 3, 3> R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R(i, j) = cosine_part * w[i] * w[j];
    R(i, i) += T(1.0) - cosine_part * t;
  }
  R(0, 1) -= sine_part * w[2];
  R(0, 2) += sine_part * w[1];
  R(1, 0) += sine_part * w[2];
  R(1, 2) -= sine_part * w[0];
  R(2, 0) -= sine_part * w[1];
  R(2, 1) += sine_part * w[0];
  return R;
}

/// R times a turn about its own axis 0, 1 or 2 (x, y, z).
template <typename T>
void turn_about(Eigen::Matrix<T, 3, 3>& R, int axis, const T& angle) {
  using std::cos;
  using std::sin;
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  const T c = cos(angle);
  const T s = sin(angle);
  for (int i = 0; i < 3; ++i) {
    const T before = R(i, a);
    R(i, a) = c * before + s * R(i, b);
    R(i, b) = c * R(i, b) - s * before;
  }
}

/// The rotation vector of R, its angle in [0, pi].
[[nodiscard]] Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

}  // namespace sixdial::geometry
