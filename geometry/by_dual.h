// forward and forward_derivative of a robot kind from one function template, for kinds that
// write their kinematics once for any number type:
//
//   struct Arm {
//     template <typename T>
//     static Reached frames(const RobotModel&, std::span<const T> v, std::span<const T> q,
//                           Assembly, std::span<Pose<T>> X) { ... }
//   };
//   constinit const RobotKind arm{..., .forward = forward_of<Arm>,
//                                 .forward_derivative = derivative_of<Arm>};
#pragma once

#include <algorithm>
#include <vector>

#include "geometry/dual.h"
#include "geometry/robot_kind.h"

namespace sixdial::geometry {

template <typename Kind>
Reached forward_of(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly assembly, std::span<Pose<double>> X) {
  return Kind::template frames<double>(robot, v, q, assembly, X);
}

/// Eight variables at a time. The turn of a frame comes from dR R' = [w] (skew).
template <typename Kind>
Reached derivative_of(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly assembly, Frames& at) {
  constexpr int kAtOnce = 8;
  using Number = Dual<kAtOnce>;
  const auto joints = static_cast<int>(q.size());
  const int all = joints + static_cast<int>(v.size());
  std::vector<Number> parameters(v.begin(), v.end());
  std::vector<Number> values(q.begin(), q.end());
  std::vector<Pose<Number>> X(at.X.size());
  const auto variable = [&](int k) -> Number& {
    return k < joints ? values[static_cast<std::size_t>(k)]
                      : parameters[static_cast<std::size_t>(k - joints)];
  };
  for (int first = 0; first < all; first += kAtOnce) {
    const int count = std::min(kAtOnce, all - first);
    for (int k = 0; k < count; ++k) variable(first + k).d[k] = 1.0;
    const Reached reached =
        Kind::template frames<Number>(robot, parameters, values, assembly, X);
    if (!reached) return reached;
    for (int k = 0; k < count; ++k) {
      variable(first + k).d[k] = 0.0;
      for (std::size_t frame = 0; frame < X.size(); ++frame) {
        Eigen::Matrix3d R;
        Eigen::Matrix3d dR;
        Eigen::Matrix<double, 6, 1> twist;
        for (int i = 0; i < 3; ++i) {
          twist[i] = X[frame].p[i].d[k];
          at.X[frame].p[i] = X[frame].p[i].value;
          for (int j = 0; j < 3; ++j) {
            R(i, j) = X[frame].R(i, j).value;
            dR(i, j) = X[frame].R(i, j).d[k];
          }
        }
        at.X[frame].R = R;
        const Eigen::Matrix3d skew = dR * R.transpose();
        twist.tail<3>() << skew(2, 1), skew(0, 2), skew(1, 0);
        if (first + k < joints) {
          at.by_q[frame].col(first + k) = twist;
        } else {
          at.by_v[frame].col(first + k - joints) = twist;
        }
      }
    }
  }
  return {};
}

}  // namespace sixdial::geometry
