#include "session/plan_at_sockets.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "geometry/long_work.h"
#include "geometry/units.h"
#include "session/planner_in_space.h"

namespace sixdial::session {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Joint travel of a straight move of the tool in the worst direction, its turn kept where the
/// robot has joints for that, over that of a lever as long as the arm: 1 is the least there is.
double travel_of(const geometry::RobotModel& robot, const geometry::Frames& at) {
  const geometry::Twists& by_q = at.by_q[0];
  double size_mm = 1.0;  // how far a turn carries the tool
  for (Index k = 0; k < by_q.cols(); ++k) {
    if (robot.joints[static_cast<std::size_t>(k)].kind == geometry::JointKind::kRevolute) {
      size_mm = std::max(size_mm, by_q.col(k).head<3>().norm());
    }
  }
  const Index rows = by_q.cols() >= 6 ? 6 : 3;
  MatrixXd J = by_q.topRows(rows);
  J.bottomRows(rows - 3) *= size_mm;
  for (Index k = 0; k < J.cols(); ++k) {
    if (robot.joints[static_cast<std::size_t>(k)].kind == geometry::JointKind::kPrismatic) {
      J.col(k) *= size_mm;
    }
  }
  // Least joint travel for a motion e: J'(J J')^-1 e, of squared length e'(J J')^-1 e.
  const Eigen::LLT<MatrixXd> llt(J * J.transpose());
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const MatrixXd inverse = llt.solve(MatrixXd::Identity(rows, rows));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moves(inverse.topLeftCorner<3, 3>());
  return size_mm * std::sqrt(std::max(0.0, moves.eigenvalues()[2]));
}

/// What stood in the way of the draws.
struct Hindered {
  int reached = 0;  // draws that put the ball there at all
  int leaning = 0;  // of those within the joints' ranges
  int singular = 0;
  double least_lean_rad = std::numbers::pi;
};

PlanRefusal refusal_at(
    const Vector3d& at_mm, const Hindered& by, const SeatRule& rule, const DrawnPoses& drawn) {
  if (by.reached == 0) {
    return refusal_of(
        at_mm, "the robot does not reach it", "put the socket where the arm can go");
  }
  if (by.singular > 0) {
    return refusal_of(
        at_mm, "every good way to reach it lies almost at a singular pose",
        "put the socket farther from the ends of the arm's reach");
  }
  if (by.leaning > 0) {
    return refusal_of(
        at_mm,
        fmt::format(
            "in none of {} ways to reach it the ball's stem leans by at most {:.0f} deg from "
            "the socket's axis; the least is {:.0f} deg",
            by.leaning, rule.cone_rad * geometry::kDegPerRad,
            by.least_lean_rad * geometry::kDegPerRad),
        "put the socket lower or nearer, give a wider cone, or say how the ball is mounted");
  }
  return refusal_of(
      at_mm,
      fmt::format(
          "the robot cannot take any of {} ways to reach it; the last one: {}", by.reached,
          drawn.why),
      "put the socket elsewhere, or look at the ranges in [[joint]]");
}

}  // namespace

double lean_of(const SeatRule& rule, const Eigen::Matrix3d& R_WE) {
  const Vector3d down = -(R_WE * rule.stem.normalized());
  return std::acos(std::clamp(down.dot(rule.axis.normalized()), -1.0, 1.0));
}

tl::expected<DrawnPoses, PlanRefusal> drawn_at_socket(
    const geometry::Rig& rig, const Vector3d& at_mm, const SeatRule& rule, int count,
    Uniform& random) {
  constexpr std::int64_t kToReach = 12;        // draws that find whether it can be reached
  constexpr std::int64_t kToFindOne = 20'000;  // and whether there is any good pose
  const PlannerInSpace planner(rig, rig.robot.working_mode);
  const geometry::RobotModel& robot = *rig.robot.model;
  geometry::Frames at(robot);
  DrawnPoses drawn;
  Hindered by;
  const std::int64_t most = std::max(std::int64_t{kMostDrawsPerPoint} * count, kToFindOne);
  while (std::ssize(drawn.poses) < count && drawn.draws < most) {
    geometry::check_end();
    ++drawn.draws;
    TriedPose tried = planner.as_it_comes(at_mm, planner.drawn_joints(random));
    if (tried.reached) ++by.reached;
    if (by.reached == 0 && drawn.draws >= kToReach) break;
    if (drawn.poses.empty() && drawn.draws >= kToFindOne) break;
    if (!tried.pose) {
      drawn.why = std::move(tried.why);
      continue;
    }
    const VectorXd& q = tried.pose->q;
    if (!robot.forward_derivative(rig.robot.nominal, q, rig.robot.assembly, at)) continue;
    const double lean_rad = lean_of(rule, at.X[0].R);
    by.least_lean_rad = std::min(by.least_lean_rad, lean_rad);
    if (lean_rad > rule.cone_rad) {
      ++by.leaning;
    } else if (travel_of(robot, at) > kMostTravel) {
      ++by.singular;
    } else {
      drawn.poses.push_back(*std::move(tried.pose));
    }
  }
  drawn.last_mm = at_mm;
  if (drawn.poses.empty()) return tl::unexpected(refusal_at(at_mm, by, rule, drawn));
  return drawn;
}

}  // namespace sixdial::session
