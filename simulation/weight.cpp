#include "simulation/weight.h"

namespace sixdial::simulation {

Weight::Weight(const geometry::RobotModel& robot, const geometry::Values& v)
    : robot_(robot), applies_(robot.axes == 3 && !robot.kind->has_passive_joints) {
  if (!applies_) return;
  v_ = v;
  frames_ = geometry::Frames(robot);
  for (std::size_t k = 0; k < robot.parameters.size(); ++k) {
    if (robot.parameters[k].stands) v_[static_cast<Eigen::Index>(k)] = 0.0;
  }
}

void Weight::take(const Eigen::VectorXd& q, geometry::Assembly assembly, Circumstance& sample) {
  if (!applies_ || q.size() != robot_.joint_count()) return;
  if (!robot_.forward_derivative(v_, q, assembly, frames_)) return;
  sample.weight_m = along(-Eigen::Vector3d::UnitZ(), q.size());
  sample.weight_sideways_m = along(Eigen::Vector3d::UnitX(), q.size());
}

/// Joints x 2: of masses in the links, and in the tool.
Eigen::MatrixXd Weight::along(const Eigen::Vector3d& down, Eigen::Index joints) const {
  constexpr double kMetre_mm = 1000.0;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(joints, 2);
  result.col(1) = frames_.by_q[0].topRows<3>().transpose() * down / kMetre_mm;
  for (std::size_t k = 1; k < frames_.by_q.size(); ++k) {
    result.col(0) += frames_.by_q[k].topRows<3>().transpose() * down / kMetre_mm;
  }
  return result;
}

}  // namespace sixdial::simulation
