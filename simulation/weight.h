// What weight does to the joints of an arm: the moment that each carries, by virtual work. The
// masses are not known, so that each counts one; an effect scales them
// (Circumstance::weight_m).
//
//   Weight weight(robot, v);
//   weight.take(q, assembly, sample);  // sets weight_m and weight_sideways_m
#pragma once

#include <Eigen/Core>

#include "geometry/robot_kind.h"
#include "simulation/effect.h"

namespace sixdial::simulation {

class Weight {
 public:
  /// The robot with these parameters, upright on its base: where it stands does not count. Of a
  /// robot in the plane or with passive joints nothing is ever set.
  Weight(const geometry::RobotModel& robot, const geometry::Values& v);

  /// Of joint values that have no pose nothing is set.
  void take(const Eigen::VectorXd& q, geometry::Assembly assembly, Circumstance& sample);

  /// The same moments of single masses: joints x 4n [m for a unit of weight], n frames without
  /// the tool's. Columns 0 to n - 1: a mass at each frame. Then three for each frame: what
  /// changes if that mass lies off it along x, y, z by a fifth of the longer link that meets
  /// there. Empty where `take` would set nothing.
  [[nodiscard]] Eigen::MatrixXd of_each_mass(
      const Eigen::VectorXd& q, geometry::Assembly assembly);

 private:
  [[nodiscard]] Eigen::MatrixXd along(const Eigen::Vector3d& down, Eigen::Index joints) const;

  const geometry::RobotModel& robot_;
  bool applies_ = false;
  Eigen::VectorXd v_;
  geometry::Frames frames_;
};

/// The effect that scales these moments, with equal masses. Not null.
[[nodiscard]] const Effect* compliance_under_weight();

}  // namespace sixdial::simulation
