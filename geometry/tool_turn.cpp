#include "geometry/tool_turn.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/base_frame.h"
#include "geometry/lever.h"
#include "geometry/rotation.h"
#include "geometry/units.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kDraws = 60;
constexpr std::size_t kPoses = 12;
constexpr double kSix = 1e-4;  // sixth singular value over the first: six directions
constexpr double kStep_rad = 10.0 * kRadPerDeg;
constexpr int kRounds = 12;
constexpr double kClosure_mm = 1e-7;
constexpr double kFollows = 1e-5;   // of the turn that is asked for
constexpr double kOpen = 1e-10;     // singular value, relative: a direction that moves nothing
constexpr double kNoChange = 1e-7;  // of a plausible one: rounding

/// Joint values drawn from the usual ranges at which the robot has a pose.
std::vector<JointPose> drawn_poses(const RobotModel& robot, const VectorXd& v) {
  std::vector<JointPose> poses;
  std::vector<Pose<double>> X(robot.frames.size());
  const auto assembly = static_cast<Assembly>(robot.assemblies.front().number);
  std::uint64_t state = 11;
  for (int draw = 0; draw < kDraws && poses.size() < kPoses; ++draw) {
    VectorXd q(robot.joint_count());
    for (Index k = 0; k < q.size(); ++k) {
      const JointInfo& joint = robot.joints[static_cast<std::size_t>(k)];
      state = state * 6364136223846793005U + 1442695040888963407U;  // Knuth's generator
      const double share = static_cast<double>(state >> 11U) * 0x1p-53;
      q[k] = joint.low + share * (joint.high - joint.low);
    }
    if (robot.forward(v, q, assembly, X)) poses.push_back({std::move(q), assembly});
  }
  return poses;
}

/// Where the tools of all poses are to be, and how parameters bring them there.
class Turning {
 public:
  Turning(const RobotModel& robot, std::span<const JointPose> poses, const VectorXd& v)
      : robot_(robot), at_(robot), scale_(robot.parameter_count()) {
    at_.tool_only = true;
    for (Index i = 0; i < scale_.size(); ++i) {
      scale_[i] = robot.parameters[static_cast<std::size_t>(i)].change;
    }
    for (const JointPose& pose : poses) {
      if (!robot.forward_derivative(v, pose.q, pose.assembly, at_)) continue;
      poses_.push_back(pose);
      from_.push_back(at_.X[0]);
    }
  }

  [[nodiscard]] bool any() const { return !poses_.empty(); }
  [[nodiscard]] const VectorXd& scale() const { return scale_; }

  /// What is missing [mm, turns at a lever] where every tool is to be turned by R from where it
  /// began; `J` by scaled parameters. False: a pose cannot be reached.
  bool look(const VectorXd& v, const Matrix3d& R, VectorXd& missing, MatrixXd& J) {
    missing.resize(6 * std::ssize(poses_));
    J.resize(missing.size(), scale_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (!robot_.forward_derivative(v, poses_[i].q, poses_[i].assembly, at_)) return false;
      const Index row = 6 * static_cast<Index>(i);
      missing.segment<3>(row) = from_[i].p - at_.X[0].p;
      const Matrix3d left = from_[i].R * R * at_.X[0].R.transpose();
      missing.segment<3>(row + 3) = kUsualLever_mm * rotation_vector(left);
      J.middleRows(row, 6) = at_.by_v[0] * scale_.asDiagonal();
      J.middleRows(row + 3, 3) *= kUsualLever_mm;
    }
    return true;
  }

  /// Newton's steps until every tool is turned by R.
  bool settle(const Matrix3d& R, VectorXd& v) {
    VectorXd missing;
    MatrixXd J;
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    solver.setThreshold(kOpen);
    double before = INFINITY;
    for (int round = 0; round < kRounds; ++round) {
      if (!look(v, R, missing, J)) return false;
      const double now = missing.norm();
      if (now <= kClosure_mm || !(now < before)) break;
      before = now;
      solver.compute(J);
      v += scale_.cwiseProduct(solver.solve(missing));
    }
    return look(v, R, missing, J) && missing.cwiseAbs().maxCoeff() <= 100.0 * kClosure_mm;
  }

 private:
  const RobotModel& robot_;
  Frames at_;
  std::vector<JointPose> poses_;
  std::vector<Pose<double>> from_;
  VectorXd scale_;
};

}  // namespace

tl::expected<Matrix3d, KinematicTrouble> turn_of_tool(
    const RobotModel& robot, const VectorXd& v, const VectorXd& q, Assembly assembly) {
  std::vector<Pose<double>> X(robot.frames.size());
  if (const auto reached = robot.forward(v, q, assembly, X); !reached) {
    return tl::unexpected(reached.error());
  }
  return X[0].R;
}

double turn_between(const Matrix3d& a, const Matrix3d& b) {
  return rotation_vector(a.transpose() * b).norm();
}

bool reaches_any_turn(const RobotModel& robot, const VectorXd& v) {
  if (robot.kind->inverse == nullptr || robot.axes != 3 || robot.joint_count() < 6) {
    return false;
  }
  Frames at(robot);
  at.tool_only = true;
  for (const JointPose& pose : drawn_poses(robot, v)) {
    if (!robot.forward_derivative(v, pose.q, pose.assembly, at)) continue;
    MatrixXd J = at.by_q[0];
    J.bottomRows<3>() *= kUsualLever_mm;
    for (Index k = 0; k < J.cols(); ++k) {
      const double size = J.col(k).norm();
      if (size > 0.0) J.col(k) /= size;
    }
    const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(J).singularValues();
    if (singular[5] > kSix * singular[0]) return true;
  }
  return false;
}

tl::expected<VectorXd, KinematicTrouble> joints_for_pose(
    const RobotModel& robot, const VectorXd& v, const Pose<double>& X_WE, WorkingMode mode,
    const std::optional<VectorXd>& near) {
  if (robot.kind->inverse == nullptr) return tl::unexpected(KinematicTrouble::kNoInverse);
  const auto span_of = [](const VectorXd& values) {
    return std::span<const double>(values.data(), static_cast<std::size_t>(values.size()));
  };
  return robot.kind->inverse(
      robot, span_of(v), X_WE, mode, near ? span_of(*near) : std::span<const double>{});
}

std::optional<VectorXd> with_tool_turned(
    const RobotModel& robot, const VectorXd& v, const Matrix3d& R) {
  const std::vector<JointPose> poses = drawn_poses(robot, v);
  Turning turning(robot, poses, v);
  if (!turning.any()) return std::nullopt;
  const Eigen::Vector3d w = rotation_vector(R);
  const int steps = std::max(1, static_cast<int>(std::ceil(w.norm() / kStep_rad)));
  VectorXd turned = v;
  for (int step = 1; step <= steps; ++step) {
    const Eigen::Vector3d part = static_cast<double>(step) / steps * w;
    if (!turning.settle(turned_by<double>(part), turned)) return std::nullopt;
  }
  for (Index i = 0; i < v.size(); ++i) {
    if (std::abs(turned[i] - v[i]) < kNoChange * turning.scale()[i]) turned[i] = v[i];
  }
  return turned;
}

bool turns_its_tool(const RobotModel& robot, const VectorXd& v) {
  if (robot.axes != 3) return false;
  const std::vector<JointPose> poses = drawn_poses(robot, v);
  Turning turning(robot, poses, v);
  VectorXd missing;
  MatrixXd J;
  if (!turning.any()) return false;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(kOpen);
  for (Index axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d w = 1e-3 * Eigen::Vector3d::Unit(axis);
    if (!turning.look(v, turned_by<double>(w), missing, J)) return false;
    if (axis == 0) solver.compute(J);
    const VectorXd left = missing - J * solver.solve(missing);
    if (!(left.norm() <= kFollows * missing.norm())) return false;
  }
  return true;
}

}  // namespace sixdial::geometry
