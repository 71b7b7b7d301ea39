#include "tests/support/test_arms.h"

#include <cmath>
#include <numbers>

#include "geometry/by_dual.h"

namespace sixdial::geometry {
namespace {

template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

template <typename T>
Matrix3<T> about(int axis, const T& angle) {
  using std::cos;
  using std::sin;
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  Matrix3<T> R = Matrix3<T>::Identity();
  R(a, a) = R(b, b) = cos(angle);
  R(b, a) = sin(angle);
  R(a, b) = -R(b, a);
  return R;
}

ParameterInfo length(std::string name) { return {name, name + "_mm", "mm"}; }
ParameterInfo angle(std::string name) {
  return {name, name + "_rad", "rad", 1.0, "rad", 1.0 / 60.0};
}

struct PlanarArm {
  enum Parameter : std::size_t { kX, kY, kLength1, kLength2, kOffset1, kOffset2 };

  template <typename T>
  static Reached frames(
      const RobotModel&, std::span<const T> v, std::span<const T> q, Assembly,
      std::span<Pose<T>> X) {
    if (!(v[kLength1] > T(0.0)) || !(v[kLength2] > T(0.0))) {
      return tl::unexpected(KinematicTrouble::kBadParameters);
    }
    const Vector3<T> x(T(1.0), T(0.0), T(0.0));
    const Vector3<T> y(T(0.0), T(1.0), T(0.0));
    const Matrix3<T> R1 = about<T>(2, q[0] + v[kOffset1]);
    const Matrix3<T> R2 = R1 * about<T>(2, q[1] + v[kOffset2]);
    X[1].p = Vector3<T>(v[kX], v[kY], T(0.0)) + R1 * x * v[kLength1];
    X[1].R = R1;
    X[0].p = X[1].p + R2 * (x * v[kLength2] + y * q[2]);
    X[0].R = R2;
    return {};
  }

  static tl::expected<Eigen::VectorXd, KinematicTrouble> inverse(
      const RobotModel&, std::span<const double> v, const Pose<double>& X_WE, WorkingMode mode,
      std::span<const double> near) {
    const double x = X_WE.p.x() - v[kX];
    const double y = X_WE.p.y() - v[kY];
    const double a = v[kLength1];
    const double b = v[kLength2];
    const double cosine = (x * x + y * y - a * a - b * b) / (2 * a * b);
    if (std::abs(cosine) >= 1.0) return tl::unexpected(KinematicTrouble::kOutOfReach);
    const double bend = (mode.number == 0 ? 1.0 : -1.0) * std::acos(cosine);
    Eigen::VectorXd q(3);
    q << std::atan2(y, x) - std::atan2(b * std::sin(bend), a + b * std::cos(bend)) -
             v[kOffset1],
        bend - v[kOffset2], 0.0;
    for (std::size_t i = 0; i < 2 && !near.empty(); ++i) {
      double& each = q[static_cast<Eigen::Index>(i)];
      each = near[i] + std::remainder(each - near[i], 2 * std::numbers::pi);
    }
    return q;
  }
};

struct SpatialArm {
  static constexpr std::size_t kRow = 4;  // a, alpha, d, theta of each axis, after the base

  template <typename T>
  static Reached frames(
      const RobotModel& robot, std::span<const T> v, std::span<const T> q, Assembly,
      std::span<Pose<T>> X) {
    Pose<T> at;
    at.p = Vector3<T>(v[0], v[1], v[2]);
    at.R = about<T>(0, v[3]) * about<T>(1, v[4]) * about<T>(2, v[5]);
    const Vector3<T> x(T(1.0), T(0.0), T(0.0));
    const Vector3<T> z(T(0.0), T(0.0), T(1.0));
    for (std::size_t i = 0; i < q.size(); ++i) {
      const std::span<const T> row = v.subspan(6 + kRow * i, kRow);
      const bool slides = robot.joints[i].kind == JointKind::kPrismatic;
      const T turn = slides ? row[3] : row[3] + q[i];
      const T shift = slides ? row[2] + q[i] : row[2];
      at.p += at.R * z * shift;
      at.R = (at.R * about<T>(2, turn)).eval();
      at.p += at.R * x * row[0];
      at.R = (at.R * about<T>(0, row[1])).eval();
      if (i == 1) X[1] = at;
    }
    X[0] = at;
    return {};
  }
};

std::shared_ptr<const RobotModel> planar_model();
std::shared_ptr<const RobotModel> spatial_model();

std::shared_ptr<const RobotModel> planar_model() {
  static const auto model = [] {
    RobotModel robot;
    robot.kind = &planar_arm();
    robot.joints = {
        {"shoulder", JointKind::kRevolute, -1.0, 1.0},
        {"elbow", JointKind::kRevolute, 0.3, 2.5},
        {"wrist", JointKind::kPrismatic, -10.0, 10.0}};
    robot.parameters = {length("x0"),     length("y0"),     length("first"),
                        length("second"), angle("offset1"), angle("offset2")};
    robot.nominal = (Eigen::VectorXd(6) << 5, -3, 200, 150, 0.1, -0.2).finished();
    robot.frames = {"E", "first"};
    robot.assemblies = {{+1, "the one"}};
    robot.modes = {{0, "left"}, {1, "right"}};
    return std::make_shared<const RobotModel>(std::move(robot));
  }();
  return model;
}

std::shared_ptr<const RobotModel> spatial_model() {
  static const auto model = [] {
    RobotModel robot;
    robot.kind = &spatial_arm();
    for (int i = 0; i < 6; ++i) {
      const bool slides = i == 2;
      robot.joints.push_back(
          {std::string("q") + std::to_string(i + 1),
           slides ? JointKind::kPrismatic : JointKind::kRevolute, slides ? 20.0 : -2.0,
           slides ? 120.0 : 2.0});
    }
    robot.parameters = {length("x0"), length("y0"), length("z0"),
                        angle("rx0"), angle("ry0"), angle("rz0")};
    robot.nominal = Eigen::VectorXd::Zero(30);
    for (int i = 0; i < 6; ++i) {
      const std::string number = std::to_string(i + 1);
      robot.parameters.push_back(length("a" + number));
      robot.parameters.push_back(angle("alpha" + number));
      robot.parameters.push_back(length("d" + number));
      robot.parameters.push_back(angle("theta" + number));
      robot.nominal.segment<4>(6 + 4 * i) << 30.0 + 10.0 * i, i % 2 == 0 ? 1.5 : -1.4, 40.0,
          0.1 * i;
    }
    robot.frames = {"E", "link2"};
    robot.axes = 3;
    robot.assemblies = {{+1, "the one"}};
    robot.modes = {{0, "the one"}};
    return std::make_shared<const RobotModel>(std::move(robot));
  }();
  return model;
}

}  // namespace

const RobotKind& planar_arm() {
  static const RobotKind& row = add_robot_kind(
      {.name = "planar_arm",
       .in_words = "planar arm",
       .example = planar_model,
       .forward = forward_of<PlanarArm>,
       .forward_derivative = derivative_of<PlanarArm>,
       .inverse = PlanarArm::inverse});
  return row;
}

const RobotKind& spatial_arm() {
  static const RobotKind& row = add_robot_kind(
      {.name = "spatial_arm",
       .in_words = "arm with six axes",
       .example = spatial_model,
       .forward = forward_of<SpatialArm>,
       .forward_derivative = derivative_of<SpatialArm>});
  return row;
}

}  // namespace sixdial::geometry
