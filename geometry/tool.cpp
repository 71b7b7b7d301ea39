#include "geometry/tool.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "geometry/rig.h"

namespace sixdial::geometry {
namespace {

std::span<const double> span_of(const Values& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

}  // namespace

Tool::Tool(std::shared_ptr<const RobotModel> robot, int axes)
    : robot_(std::move(robot)), axes_(axes) {}

Tool::Tool(const Rig& rig) : Tool(rig.robot.model, rig.instrument.dimensions) {}

tl::expected<Position, KinematicTrouble> Tool::position(
    const Values& v, const Values& q, Assembly assembly) const {
  std::vector<Pose<double>> X(robot_->frames.size());
  if (const auto reached = robot_->forward(v, q, assembly, X); !reached) {
    return tl::unexpected(reached.error());
  }
  return Position(X[0].p.head(axes_));
}

tl::expected<ToolDerivative, KinematicTrouble> Tool::derivative(
    const Values& v, const Values& q, Assembly assembly) const {
  Frames at(*robot_);
  if (const auto reached = robot_->forward_derivative(v, q, assembly, at); !reached) {
    return tl::unexpected(reached.error());
  }
  return ToolDerivative{
      at.X[0].p.head(axes_), at.by_v[0].topRows(axes_), at.by_q[0].topRows(axes_)};
}

tl::expected<Eigen::VectorXd, KinematicTrouble> Tool::inverse(
    const Values& v, const Values& p_WE, WorkingMode mode,
    const std::optional<Eigen::VectorXd>& near) const {
  if (robot_->kind->inverse == nullptr) return tl::unexpected(KinematicTrouble::kNoInverse);
  Pose<double> X_WE;
  X_WE.p.head(p_WE.size()) = p_WE;
  if (axes_ == 3) {
    // Turned as it is now, or as it comes.
    X_WE.R.setConstant(std::numeric_limits<double>::quiet_NaN());
    std::vector<Pose<double>> X(robot_->frames.size());
    const auto assembly = static_cast<Assembly>(robot_->assemblies.front().number);
    if (near && robot_->forward(v, *near, assembly, X)) X_WE.R = X[0].R;
  }
  return robot_->kind->inverse(
      *robot_, span_of(v), X_WE, mode, near ? span_of(*near) : std::span<const double>{});
}

tl::expected<Assembly, KinematicTrouble> Tool::assembly_at(
    const Values& v, const Values& q, const Values& p_WE) const {
  std::optional<Assembly> nearest;
  std::optional<KinematicTrouble> trouble;
  double least_mm2 = 0.0;
  std::vector<Pose<double>> X(robot_->frames.size());
  for (const BranchInfo& each : robot_->assemblies) {
    const auto assembly = static_cast<Assembly>(each.number);
    if (const auto reached = robot_->forward(v, q, assembly, X); !reached) {
      if (!trouble) trouble = reached.error();
      continue;
    }
    const double miss_mm2 = (X[0].p.head(p_WE.size()) - p_WE).squaredNorm();
    if (nearest && miss_mm2 >= least_mm2) continue;
    nearest = assembly;
    least_mm2 = miss_mm2;
  }
  if (!nearest) return tl::unexpected(trouble.value_or(KinematicTrouble::kBadParameters));
  return *nearest;
}

tl::expected<WorkingMode, KinematicTrouble> Tool::mode_of(
    const Values& v, const Values& q, Assembly assembly) const {
  if (robot_->kind->mode_of != nullptr) {
    return robot_->kind->mode_of(*robot_, span_of(v), span_of(q), assembly);
  }
  const WorkingMode first(robot_->modes.front().number);
  if (robot_->modes.size() == 1 || !has_inverse()) return first;
  const auto p_WE = position(v, q, assembly);
  if (!p_WE) return tl::unexpected(p_WE.error());
  std::optional<WorkingMode> nearest;
  double least = 0.0;
  for (const BranchInfo& each : robot_->modes) {
    const WorkingMode mode(each.number);
    const auto there = inverse(v, *p_WE, mode, Eigen::VectorXd(q));
    if (!there) continue;
    const double apart = (*there - q).squaredNorm();
    if (nearest && apart >= least) continue;
    nearest = mode;
    least = apart;
  }
  return nearest.value_or(first);
}

tl::expected<PlanarPose, KinematicTrouble> planar_pose(
    const RobotModel& robot, const Values& v, const Values& q, Assembly assembly,
    std::optional<int> link, Eigen::Matrix2Xd* J_q) {
  if (robot.kind->in_plane != nullptr) {
    return robot.kind->in_plane(robot, span_of(v), span_of(q), assembly, link, J_q);
  }
  Frames at(robot);
  const auto reached = J_q != nullptr ? robot.forward_derivative(v, q, assembly, at)
                                      : robot.forward(v, q, assembly, at.X);
  if (!reached) return tl::unexpected(reached.error());
  if (J_q != nullptr) *J_q = at.by_q[0].topRows<2>();
  PlanarPose pose{.p_WE = at.X[0].p.head<2>()};
  if (link) {
    const Eigen::Matrix3d& R = at.X[static_cast<std::size_t>(*link)].R;
    pose.link_rad = std::atan2(R(1, 0), R(0, 0));
  }
  return pose;
}

}  // namespace sixdial::geometry
