#include "geometry/robots/rotary_delta.h"

#include <cmath>
#include <numbers>

#include "geometry/by_dual.h"
#include "geometry/robots/parameter_row.h"
#include "geometry/robots/three_spheres.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

enum Parameter : std::size_t {
  kBase = 0,
  kRadius = 6,
  kAngle = 7,
  kArm = 10,
  kRod = 13,
  kZero = 16
};
constexpr std::size_t kCount = 19;
constexpr int kBelow = +1;
constexpr int kAbove = -1;

template <typename T>
using Vector = Eigen::Matrix<T, 3, 1>;

struct Delta {
  template <typename T>
  static Reached frames(
      const RobotModel& /*robot*/, std::span<const T> v, std::span<const T> q,
      Assembly assembly, std::span<Pose<T>> X) {
    using std::cos;
    using std::sin;
    std::array<Vector<T>, 3> knee;
    std::array<T, 3> rod;
    for (std::size_t i = 0; i < 3; ++i) {
      rod[i] = v[kRod + i];
      if (!(v[kArm + i] > T(0.0)) || !(rod[i] > T(0.0))) {
        return tl::unexpected(KinematicTrouble::kBadParameters);
      }
      const T at = q[i] + v[kZero + i];
      const T out = v[kRadius] + v[kArm + i] * cos(at);
      knee[i] = {out * cos(v[kAngle + i]), out * sin(v[kAngle + i]), -(v[kArm + i] * sin(at))};
    }
    const auto p_BE = three_spheres<T>(knee, rod, static_cast<int>(assembly));
    if (!p_BE) return tl::unexpected(KinematicTrouble::kOutOfReach);
    const Vector<T> p_WB(v[kBase], v[kBase + 1], v[kBase + 2]);
    const Eigen::Matrix<T, 3, 3> R_WB =
        turned_by<T>({v[kBase + 3], v[kBase + 4], v[kBase + 5]});
    X[0] = {p_WB + R_WB * *p_BE, R_WB};
    for (std::size_t i = 0; i < 3; ++i) X[i + 1] = {p_WB + R_WB * knee[i], R_WB};
    return {};
  }
};

/// Of a leg's plane: x out, z up, y across. The arm with its knee outside (mode 0) or inside.
tl::expected<double, KinematicTrouble> arm_angle(
    const Eigen::Vector3d& p, double radius, double arm, double rod, int mode) {
  const double x = p.x() - radius;
  const double in_plane2 = rod * rod - p.y() * p.y();
  // |(x - arm cos, z + arm sin)|^2 = in_plane2  ->  x cos - z sin = c
  const double c = (x * x + p.z() * p.z() + arm * arm - in_plane2) / (2.0 * arm);
  const double r = std::hypot(x, p.z());
  if (!(in_plane2 > 0.0) || !(std::abs(c) < r)) {
    return tl::unexpected(KinematicTrouble::kOutOfReach);
  }
  const double bend = std::acos(c / r);
  return std::atan2(-p.z(), x) + (mode == 0 ? -bend : bend);
}

tl::expected<Eigen::VectorXd, KinematicTrouble> joints_at(
    const RobotModel& /*robot*/, std::span<const double> v, const Pose<double>& X_WE,
    WorkingMode mode, std::span<const double> near) {
  const Eigen::Vector3d p_WB(v[kBase], v[kBase + 1], v[kBase + 2]);
  const Eigen::Matrix3d R_WB = turned_by<double>({v[kBase + 3], v[kBase + 4], v[kBase + 5]});
  const Eigen::Vector3d p_BE = R_WB.transpose() * (X_WE.p - p_WB);
  Eigen::VectorXd q(3);
  for (std::size_t i = 0; i < 3; ++i) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    turn_about<double>(R, 2, v[kAngle + i]);
    const auto at =
        arm_angle(R.transpose() * p_BE, v[kRadius], v[kArm + i], v[kRod + i], mode.number);
    if (!at) return tl::unexpected(at.error());
    double& each = q[static_cast<Eigen::Index>(i)];
    each = std::remainder(*at - v[kZero + i], 2.0 * std::numbers::pi);
    if (!near.empty()) each = near[i] + std::remainder(each - near[i], 2.0 * std::numbers::pi);
  }
  return q;
}

/// By the first arm: all three are set to one side.
tl::expected<WorkingMode, KinematicTrouble> mode_at(
    const RobotModel& robot, std::span<const double> v, std::span<const double> q,
    Assembly assembly) {
  std::vector<Pose<double>> X(4);
  if (const auto reached = Delta::frames<double>(robot, v, q, assembly, X); !reached) {
    return tl::unexpected(reached.error());
  }
  double nearest = HUGE_VAL;
  WorkingMode found;
  for (const BranchInfo& mode : robot.modes) {
    const auto back = joints_at(robot, v, X[0], WorkingMode(mode.number), q);
    if (!back) return tl::unexpected(back.error());
    const double apart = std::abs((*back)[0] - q[0]);
    if (apart < nearest) found = WorkingMode(mode.number);
    nearest = std::min(nearest, apart);
  }
  return found;
}

std::shared_ptr<const RobotModel> example() {
  static const auto model = [] {
    constexpr double kLever_mm = 150.0;
    RobotModel robot;
    robot.kind = &rotary_delta;
    robot.axes = 3;
    robot.frames = {"E"};
    add_frame_rows(robot.parameters, "base", kLever_mm, "where the delta stands");
    robot.parameters.push_back(length_row("radius", "motors' radius less the platform's"));
    robot.parameters.back().grows = true;
    constexpr std::array<const char*, 3> kLegs{"a", "b", "c"};
    for (const std::string leg : kLegs) {
      robot.joints.push_back(
          {"q" + std::to_string(robot.joints.size() + 1), JointKind::kRevolute, 0.1, 1.0});
      robot.frames.push_back("knee_" + leg);
      robot.parameters.push_back(
          angle_row("angle_" + leg, kLever_mm, "direction of leg " + leg));
    }
    for (const std::string leg : kLegs) {
      robot.parameters.push_back(length_row("arm_" + leg, "upper arm of leg " + leg));
      robot.parameters.back().range = FileRange::kPositive;
      robot.parameters.back().grows = true;
    }
    for (const std::string leg : kLegs) {
      robot.parameters.push_back(length_row("rod_" + leg, "rods of leg " + leg));
      robot.parameters.back().range = FileRange::kPositive;
      robot.parameters.back().grows = true;
    }
    for (const std::string leg : kLegs) {
      robot.parameters.push_back(
          angle_row("zero_" + leg, kLever_mm, "zero of the encoder of leg " + leg));
    }
    robot.nominal = Eigen::VectorXd::Zero(kCount);
    robot.nominal[kRadius] = 75.0;
    for (int i = 0; i < 3; ++i) {
      robot.nominal[static_cast<int>(kAngle) + i] = i * 2 * std::numbers::pi / 3;
      robot.nominal[static_cast<int>(kArm) + i] = 120.0;
      robot.nominal[static_cast<int>(kRod) + i] = 300.0;
    }
    robot.assemblies = {{kBelow, "below"}, {kAbove, "above"}};
    robot.modes = {{0, "out"}, {1, "in"}};
    robot.mode_in_words = "whether the knees stand outside";
    return std::make_shared<const RobotModel>(std::move(robot));
  }();
  return model;
}

}  // namespace

extern constinit const RobotKind rotary_delta{
    .name = "rotary_delta",
    .in_words = "delta with three arms",
    .has_passive_joints = true,
    .example = example,
    .forward = forward_of<Delta>,
    .forward_derivative = derivative_of<Delta>,
    .inverse = joints_at,
    .mode_of = mode_at,
};

}  // namespace sixdial::geometry
