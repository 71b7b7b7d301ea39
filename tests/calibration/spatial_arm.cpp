#include "tests/calibration/spatial_arm.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "calibration/random.h"

namespace sixdial::calibration::testing {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

enum Parameter { kHeight, kUpper, kFore, kShoulder, kElbow, kParameters };

Vector3d position(const VectorXd& v, const Vector3d& q, MatrixXd* J) {
  const double s = q[1] + v[kShoulder];
  const double t = s + q[2] + v[kElbow];
  const double r = v[kUpper] * std::cos(s) + v[kFore] * std::cos(t);
  const double up = v[kUpper] * std::sin(s) + v[kFore] * std::sin(t);
  const double fore_r = -v[kFore] * std::sin(t);  // dr/dt
  const double fore_z = v[kFore] * std::cos(t);   // dz/dt
  if (J != nullptr) {
    const auto column = [&](int k, double by_r, double by_z) {
      J->col(k) = Vector3d(by_r * std::cos(q[0]), by_r * std::sin(q[0]), by_z);
    };
    column(kHeight, 0.0, 1.0);
    column(kUpper, std::cos(s), std::sin(s));
    column(kFore, std::cos(t), std::sin(t));
    column(kShoulder, -up, r);
    column(kElbow, fore_r, fore_z);
  }
  return {r * std::cos(q[0]), r * std::sin(q[0]), v[kHeight] + up};
}

ObservationSpace without_samples() {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  ObservationSpace space;
  space.name = "positions";
  space.parameter_info = {
      {"height", "", "mm", 1.0, "mm", 1.0},
      {"upper", "", "mm", 1.0, "mm", 1.0},
      {"fore", "", "mm", 1.0, "mm", 1.0},
      {"shoulder", "", "deg", kDegrees, "rad", 0.005},
      {"elbow", "", "deg", kDegrees, "rad", 0.01}};
  space.nominal = VectorXd::Zero(kParameters);
  space.nominal.head<3>() = Vector3d(150.0, 200.0, 100.0);
  space.joint_info = {{"q1", "rad"}, {"q2", "rad"}, {"q3", "rad"}};
  space.channel_info = {{"x", "mm"}, {"y", "mm"}, {"z", "mm"}};
  space.position_axes = 3;
  space.rows_belong_together = true;
  return space;
}

ObservationSpace measured(
    const VectorXd& truth, double noise_mm, double bend_mm, int points,
    RandomSequence& random) {
  ObservationSpace space = without_samples();
  space.joints.resize(3, points);
  space.measured_mm.resize(3 * points);
  space.sigma_mm = VectorXd::Constant(3 * points, std::max(noise_mm, 1e-6));
  space.off_target_mm.resize(3, points);
  for (int i = 0; i < points; ++i) {
    const Vector3d q(
        random.uniform(-1.5, 1.5), random.uniform(0.2, 1.2), random.uniform(-2.0, -0.5));
    const Vector3d noise(random.normal(), random.normal(), random.normal());
    const Vector3d bend(std::sin(2 * q[1]), std::cos(q[2]), std::sin(q[0] + q[1]));
    const Vector3d p = position(truth, q, nullptr) + noise_mm * noise + bend_mm * bend;
    space.joints.col(i) = q;
    space.measured_mm.segment<3>(3 * i) = p;
    space.off_target_mm.col(i) = p - position(space.nominal, q, nullptr);
    space.covariance_mm2.emplace_back(noise_mm * noise_mm * MatrixXd::Identity(3, 3));
    space.sample.push_back(i);
    space.point.push_back(i);
    space.repeat.push_back(0);
    for (int axis = 0; axis < 3; ++axis) space.channel.push_back(axis);
    space.first_row.push_back(3 * (i + 1));
  }
  space.evaluate = [joints = space.joints, seen = space.measured_mm](
                       int i, const VectorXd& x, Eigen::Ref<VectorXd> e, MatrixXd* J) {
    e = seen.segment<3>(3 * i) - position(x, joints.col(i), J);
    return true;
  };
  space.position_error = [evaluate = space.evaluate](
                             int i, const VectorXd& x, Eigen::Ref<VectorXd> e) {
    return evaluate(i, x, e, nullptr);
  };
  return space;
}

}  // namespace

SpatialArm measured_arm(std::uint64_t seed, double noise_mm, double bend_mm, int points) {
  RandomSequence random(seed, 903);
  SpatialArm arm;
  arm.truth = without_samples().nominal;
  for (int k = 0; k < 3; ++k) arm.truth[k] += random.uniform(-0.5, 0.5);
  for (int k = 3; k < 5; ++k) arm.truth[k] += random.uniform(-0.005, 0.005);
  arm.g1 = measured(arm.truth, noise_mm, bend_mm, points, random);
  arm.g2 = measured(arm.truth, noise_mm, bend_mm, points / 2, random);
  return arm;
}

}  // namespace sixdial::calibration::testing
