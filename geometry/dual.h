// A number that carries N derivatives along (forward automatic differentiation): what a robot
// kind's kinematics are computed with when derivatives are asked for.
//
//   Dual<2> x(3.0, 0), y(4.0, 1);          // values, and which variable each one is
//   const Dual<2> r = sqrt(x * x + y * y);  // r.value == 5, r.d == (0.6, 0.8)
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace sixdial::geometry {

template <int N>
struct Dual {
  using Derivative = Eigen::Array<double, N, 1>;
  double value = 0.0;
  Derivative d = Derivative::Zero();

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor)
  Dual(double at, int variable) : value(at) { d[variable] = 1.0; }
  Dual(double at, const Derivative& derivative) : value(at), d(derivative) {}

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }
  friend Dual operator-(const Dual& a) { return {-a.value, -a.d}; }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.d + b.d}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.d - b.d}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.d * b.value + a.value * b.d};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double value = a.value / b.value;
    return {value, (a.d - value * b.d) / b.value};
  }
  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend bool operator!=(const Dual& a, const Dual& b) { return a.value != b.value; }

  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return {root, a.d / (2.0 * root)};
  }
  friend Dual sin(const Dual& a) { return {std::sin(a.value), std::cos(a.value) * a.d}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.value), -std::sin(a.value) * a.d}; }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double r2 = x.value * x.value + y.value * y.value;
    return {std::atan2(y.value, x.value), (x.value * y.d - y.value * x.d) / r2};
  }
  friend Dual acos(const Dual& a) {
    return {std::acos(a.value), -a.d / std::sqrt(1.0 - a.value * a.value)};
  }
  friend Dual abs(const Dual& a) { return a.value < 0.0 ? -a : a; }
  friend bool isfinite(const Dual& a) { return std::isfinite(a.value); }
};

}  // namespace sixdial::geometry

namespace Eigen {

template <int N>
struct NumTraits<sixdial::geometry::Dual<N>> : NumTraits<double> {
  using Real = sixdial::geometry::Dual<N>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = double;
  enum { RequireInitialization = 1, ReadCost = 1 + N, AddCost = 1 + N, MulCost = 3 * (1 + N) };
};

}  // namespace Eigen
