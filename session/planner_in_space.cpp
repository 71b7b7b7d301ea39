#include "session/planner_in_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "geometry/units.h"

namespace sixdial::session {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

PlannerInSpace::PlannerInSpace(const geometry::Rig& rig, geometry::WorkingMode mode)
    : rig_(rig),
      mode_(mode),
      tool_(rig.robot.model, 3),
      axes_(rig.instrument.dimensions),
      listed_(lists_its_joints(rig)) {}

VectorXd PlannerInSpace::drawn_joints(Uniform& random) const {
  VectorXd q(tool_.robot().joint_count());
  for (Index k = 0; k < q.size(); ++k) {
    const geometry::JointInfo& joint = info(k);
    q[k] = joint.low + random.next() * (joint.high - joint.low);
  }
  return q;
}

TriedPose PlannerInSpace::of_joints(const VectorXd& exact) const {
  const VectorXd q = rounded(exact, kJointDigits);
  TriedPose tried{.pose = {}, .target_mm = Position::Zero(axes_), .why = {}};
  const geometry::Robot& robot = rig_.robot;
  const auto at = tool_.position(robot.nominal, q, robot.assembly);
  if (!at) {
    tried.why = describe(at.error());
    return tried;
  }
  tried.reached = true;
  tried.target_mm = rounded(Position(at->head(axes_)), kTargetDigits);
  tried.why = beyond_range(q);
  if (tried.why.empty()) tried.why = singular_there(rig_, q, robot.assembly);
  const auto mode = tool_.mode_of(robot.nominal, q, robot.assembly);
  if (tried.why.empty() && (!mode || *mode != mode_)) {
    tried.why = "it is in another working mode there";
  }
  if (tried.why.empty()) tried.pose = {tried.target_mm, q};
  return tried;
}

TriedPose PlannerInSpace::as_it_comes(const Vector3d& target, const VectorXd& from) const {
  const geometry::RobotModel& robot = tool_.robot();
  geometry::Pose<double> X_WE{.p = target};
  X_WE.R.setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto span = [](const VectorXd& values) {
    return std::span<const double>(values.data(), static_cast<std::size_t>(values.size()));
  };
  if (robot.kind->inverse == nullptr) return refused(target, "it has no inverse");
  const auto q = robot.kind->inverse(robot, span(rig_.robot.nominal), X_WE, mode_, span(from));
  if (!q) return refused(target, std::string(describe(q.error())));
  return of_joints(*q);
}

TriedPose PlannerInSpace::turned_as(const Vector3d& target, const VectorXd& near) const {
  const auto q = tool_.inverse(rig_.robot.nominal, target, mode_, near);
  if (!q) return refused(target, std::string(describe(q.error())));
  return of_joints(*q);
}

TriedPose PlannerInSpace::with_most_room(const Vector3d& target) const {
  constexpr int kWays = 30;
  TriedPose best = as_it_comes(target, VectorXd());
  double most = best.pose ? room(best.pose->q) : -1.0;
  Uniform random(1, "ways to stand");
  for (int way = 0; way < kWays && listed_; ++way) {
    TriedPose tried = as_it_comes(target, drawn_joints(random));
    const double here = tried.pose ? room(tried.pose->q) : -1.0;
    if (here <= most) continue;
    most = here;
    best = std::move(tried);
  }
  return best;
}

TriedPose PlannerInSpace::refused(const Vector3d& target, std::string why) const {
  return {.pose = {}, .target_mm = target.head(axes_), .why = std::move(why)};
}

double PlannerInSpace::room(const VectorXd& q) const {
  double least = 0.5;
  for (Index k = 0; k < q.size() && listed_; ++k) {
    const double end = std::min(q[k] - info(k).low, info(k).high - q[k]);
    least = std::min(least, end / (info(k).high - info(k).low));
  }
  return least;
}

std::string PlannerInSpace::beyond_range(const VectorXd& q) const {
  if (!listed_) return "";
  for (Index k = 0; k < q.size(); ++k) {
    const geometry::JointInfo& joint = info(k);
    if (q[k] >= joint.low && q[k] <= joint.high) continue;
    const bool turns = joint.kind == geometry::JointKind::kRevolute;
    const double unit = turns ? geometry::kDegPerRad : 1.0;
    return fmt::format(
        "joint {} would be at {:.1f} {}, beyond its range of {:.1f} to {:.1f}", joint.name,
        q[k] * unit, turns ? "deg" : "mm", joint.low * unit, joint.high * unit);
  }
  return "";
}

}  // namespace sixdial::session
