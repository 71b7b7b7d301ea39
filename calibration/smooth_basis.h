// Smooth random functions over a session, as a few shapes: the products of two rows of shapes
// are the covariance exp(-d^2 / (2 l^2)) between two samples, d being their distance in joint
// values or in the order of measuring, as shares of the session's range.
//
//   const SmoothBasis basis(space, SmoothOver::kJoints, 0.4);
//   const Eigen::MatrixXd phi = basis(space);  // samples x shapes
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "calibration/observation_space.h"

namespace sixdial::calibration {

enum class SmoothOver { kJoints, kOrder };
/// "joints", "order".
[[nodiscard]] std::string_view to_string(SmoothOver over);

class SmoothBasis {
 public:
  /// Shapes for one channel's function over the samples of `space`; `length`: l.
  SmoothBasis(const ObservationSpace& space, SmoothOver over, double length);
  /// samples x shapes at the samples of any space with the same joints. Far outside of the
  /// session the function is not known: all shapes are 0.
  [[nodiscard]] Eigen::MatrixXd operator()(const ObservationSpace& space) const;

 private:
  [[nodiscard]] Eigen::MatrixXd places(const ObservationSpace& space) const;
  SmoothOver over_;
  double length_;
  Eigen::VectorXd low_, range_;  // by dimension
  Eigen::MatrixXd pins_;         // dimensions x pins
  Eigen::MatrixXd to_shape_;     // pins x shapes
};

}  // namespace sixdial::calibration
