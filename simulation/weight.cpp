#include "simulation/weight.h"

#include <algorithm>
#include <cstddef>

namespace sixdial::simulation {
namespace {

constexpr double kMetre_mm = 1000.0;
/// How far the centre of mass of a link lies off the line between its ends, over its length.
constexpr double kOffTheLine = 0.2;

/// Of the two links that meet at a frame (number 0 is the tool's, at the end).
double longest_link_mm(const std::vector<geometry::Pose<double>>& X, std::size_t frame) {
  const auto next = frame + 1 < X.size() ? frame + 1 : 0;
  const double after = (X[next].p - X[frame].p).norm();
  return frame > 1 ? std::max(after, (X[frame].p - X[frame - 1].p).norm()) : after;
}

}  // namespace

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
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(joints, 2);
  result.col(1) = frames_.by_q[0].topRows<3>().transpose() * down / kMetre_mm;
  for (std::size_t k = 1; k < frames_.by_q.size(); ++k) {
    result.col(0) += frames_.by_q[k].topRows<3>().transpose() * down / kMetre_mm;
  }
  return result;
}

Eigen::MatrixXd Weight::of_each_mass(const Eigen::VectorXd& q, geometry::Assembly assembly) {
  if (!applies_ || q.size() != robot_.joint_count()) return {};
  if (!robot_.forward_derivative(v_, q, assembly, frames_)) return {};
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  const auto frames = static_cast<Eigen::Index>(frames_.by_q.size()) - 1;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(q.size(), 4 * frames);
  for (Eigen::Index k = 0; k < frames; ++k) {
    const auto frame = static_cast<std::size_t>(k + 1);
    const geometry::Twists& by_q = frames_.by_q[frame];
    result.col(k) = by_q.topRows<3>().transpose() * down / kMetre_mm;
    const double off_mm = kOffTheLine * longest_link_mm(frames_.X, frame);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d off = off_mm * frames_.X[frame].R.col(axis);
      // A joint that turns about z moves what lies off by z x off.
      result.col(frames + 3 * k + axis) =
          by_q.bottomRows<3>().transpose() * off.cross(down) / kMetre_mm;
    }
  }
  return result;
}

}  // namespace sixdial::simulation
