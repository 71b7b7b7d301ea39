#include "geometry/rotation.h"

#include <Eigen/Geometry>

namespace sixdial::geometry {

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  // The quaternion keeps its digits at small angles and at half a turn.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  const double sine = q.vec().norm();
  if (sine < 1e-300) return 2.0 * q.vec();
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

}  // namespace sixdial::geometry
