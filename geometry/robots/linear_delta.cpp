#include "geometry/robots/linear_delta.h"

#include <cmath>
#include <numbers>

#include "geometry/by_dual.h"
#include "geometry/robots/parameter_row.h"
#include "geometry/robots/three_spheres.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

enum Parameter : std::size_t { kBase = 0, kRadius = 6, kAngle = 7, kRod = 10, kStop = 13 };
constexpr std::size_t kCount = 16;
constexpr int kBelow = +1;  // the platform hangs below its carriages
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
    std::array<Vector<T>, 3> carriage;
    std::array<T, 3> rod;
    for (std::size_t i = 0; i < 3; ++i) {
      rod[i] = v[kRod + i];
      if (!(v[kRadius] > T(0.0)) || !(rod[i] > T(0.0))) {
        return tl::unexpected(KinematicTrouble::kBadParameters);
      }
      carriage[i] = {
          v[kRadius] * cos(v[kAngle + i]), v[kRadius] * sin(v[kAngle + i]),
          q[i] + v[kStop + i]};
    }
    const auto p_BE = three_spheres<T>(carriage, rod, static_cast<int>(assembly));
    if (!p_BE) return tl::unexpected(KinematicTrouble::kOutOfReach);
    const Vector<T> p_WB(v[kBase], v[kBase + 1], v[kBase + 2]);
    const Eigen::Matrix<T, 3, 3> R_WB =
        turned_by<T>({v[kBase + 3], v[kBase + 4], v[kBase + 5]});
    X[0] = {p_WB + R_WB * *p_BE, R_WB};
    for (std::size_t i = 0; i < 3; ++i) X[i + 1] = {p_WB + R_WB * carriage[i], R_WB};
    return {};
  }
};

tl::expected<Eigen::VectorXd, KinematicTrouble> joints_at(
    const RobotModel& /*robot*/, std::span<const double> v, const Pose<double>& X_WE,
    WorkingMode mode, std::span<const double> /*near*/) {
  const Eigen::Vector3d p_WB(v[kBase], v[kBase + 1], v[kBase + 2]);
  const Eigen::Matrix3d R_WB = turned_by<double>({v[kBase + 3], v[kBase + 4], v[kBase + 5]});
  const Eigen::Vector3d p_BE = R_WB.transpose() * (X_WE.p - p_WB);
  Eigen::VectorXd q(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = v[kRadius] * std::cos(v[kAngle + i]) - p_BE.x();
    const double y = v[kRadius] * std::sin(v[kAngle + i]) - p_BE.y();
    const double up2 = v[kRod + i] * v[kRod + i] - x * x - y * y;
    if (!(up2 > 0.0)) return tl::unexpected(KinematicTrouble::kOutOfReach);
    const double up = mode.number == 0 ? std::sqrt(up2) : -std::sqrt(up2);
    q[static_cast<Eigen::Index>(i)] = p_BE.z() + up - v[kStop + i];
  }
  return q;
}

tl::expected<WorkingMode, KinematicTrouble> mode_at(
    const RobotModel& /*robot*/, std::span<const double> /*v*/, std::span<const double> /*q*/,
    Assembly assembly) {
  return WorkingMode(static_cast<int>(assembly) == kBelow ? 0 : 1);
}

std::shared_ptr<const RobotModel> example() {
  static const auto model = [] {
    constexpr double kLever_mm = 100.0;
    RobotModel robot;
    robot.kind = &linear_delta;
    robot.axes = 3;
    add_frame_rows(robot.parameters, "base", kLever_mm, "where the delta stands");
    robot.parameters.push_back(length_row("radius", "towers' radius less the platform's"));
    constexpr std::array<const char*, 3> kTowers{"a", "b", "c"};
    for (const std::string tower : kTowers) {
      robot.joints.push_back(
          {"q" + std::to_string(robot.joints.size() + 1), JointKind::kPrismatic, 250.0, 420.0});
      robot.frames.push_back("carriage_" + tower);
      robot.parameters.push_back(
          angle_row("angle_" + tower, kLever_mm, "direction of tower " + tower));
    }
    for (const std::string tower : kTowers) {
      robot.parameters.push_back(length_row("rod_" + tower, "rod of tower " + tower));
    }
    for (const std::string tower : kTowers) {
      robot.parameters.push_back(length_row("stop_" + tower, "zero of carriage " + tower));
    }
    for (ParameterInfo& each : robot.parameters) {
      if (each.name == "radius" || each.name.starts_with("rod")) {
        each.range = FileRange::kPositive;
        each.grows = true;
      }
    }
    robot.frames.insert(robot.frames.begin(), "E");
    robot.nominal = Eigen::VectorXd::Zero(kCount);
    robot.nominal[kRadius] = 172.0;
    for (int i = 0; i < 3; ++i) {
      robot.nominal[static_cast<int>(kAngle) + i] =
          std::numbers::pi / 2 + i * 2 * std::numbers::pi / 3;
      robot.nominal[static_cast<int>(kRod) + i] = 340.0;
    }
    robot.assemblies = {{kBelow, "below"}, {kAbove, "above"}};
    robot.modes = {{0, "below"}, {1, "above"}};
    robot.mode_in_words = "whether the platform hangs below its carriages";
    return std::make_shared<const RobotModel>(std::move(robot));
  }();
  return model;
}

}  // namespace

extern constinit const RobotKind linear_delta{
    .name = "linear_delta",
    .in_words = "delta with vertical towers",
    .has_passive_joints = true,
    .example = example,
    .forward = forward_of<Delta>,
    .forward_derivative = derivative_of<Delta>,
    .inverse = joints_at,
    .mode_of = mode_at,
};

}  // namespace sixdial::geometry
