// Where a frame is: its origin and how it is turned, for any number type (double, or a dual
// number that carries derivatives along).
#pragma once

#include <Eigen/Core>

namespace sixdial::geometry {

/// X_WF: frame F seen from W. Planar robots stay in z = 0 and turn about z.
template <typename T>
struct Pose {
  Eigen::Matrix<T, 3, 1> p = Eigen::Matrix<T, 3, 1>::Zero();      // origin [mm]
  Eigen::Matrix<T, 3, 3> R = Eigen::Matrix<T, 3, 3>::Identity();  // columns: F's axes in W
};

/// x, y and, where measured, z in W [mm].
using Position = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

/// A pose in the plane: where the tool is and which way one link points.
struct PlanarPose {
  Eigen::Vector2d p_WE{0, 0};
  double link_rad = 0.0;  // angle of the link's x axis in W; 0 where none was asked for
};

/// Derivative of a pose, one column for each variable: rows 0..2 the origin [mm per unit], rows
/// 3..5 the rotation vector in W [rad per unit].
using Twists = Eigen::Matrix<double, 6, Eigen::Dynamic>;

}  // namespace sixdial::geometry
