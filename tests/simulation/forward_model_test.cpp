#include "simulation/forward_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/by_dual.h"

namespace sixdial::simulation {
namespace {

using Eigen::Vector2d;
using geometry::Mount;

struct WithMount : testing::TestWithParam<Mount> {
  ForwardModel model = [] {
    geometry::Rig rig = geometry::default_rig();
    rig.cuboid.mount = GetParam();
    return ForwardModel(rig);
  }();
  std::mt19937_64 engine{11};
  double drawn(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  ModelVector drawn_model() {
    ModelVector result = model.nominal();
    for (int i = 0; i < 7; ++i) result[i] += drawn(-0.6, 0.6);
    for (Eigen::Index i = 7; i < model.parameter_count(); ++i) result[i] += drawn(-0.02, 0.02);
    return result;
  }
  Vector2d drawn_q() {
    const Vector2d p_WE(drawn(16, 40), drawn(30, 66));
    return *geometry::inverse(model.rig().robot.nominal, p_WE, model.rig().robot.working_mode);
  }
};

TEST_P(WithMount, JacobianAgreesWithDifferences) {
  constexpr double kRelative = 1e-7;
  for (int trial = 0; trial < 300; ++trial) {
    const ModelVector x = drawn_model();
    const Vector2d q = drawn_q();
    const Prediction exact = *model.predict(x, q, geometry::Assembly::kLeft);
    Eigen::MatrixXd slope(exact.reading.size(), model.parameter_count());
    for (Eigen::Index i = 0; i < model.parameter_count(); ++i) {
      const double h = i < 7 ? 2e-3 : 2e-5;
      const auto at = [&](double step) -> Eigen::VectorXd {
        return model
            .predict(x + step * ModelVector::Unit(x.size(), i), q, geometry::Assembly::kLeft)
            ->reading;
      };
      slope.col(i) = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    }
    ASSERT_LT((exact.reading_J - slope).norm(), kRelative * exact.reading_J.norm());
  }
}

TEST_P(WithMount, ReadingsGiveTheToolBack) {
  constexpr double kSolved_mm = 1e-10;
  int solved = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const ModelVector x = drawn_model();
    const Prediction seen = *model.predict(x, drawn_q(), geometry::Assembly::kLeft);
    std::vector<geometry::DialReading> readings;
    for (int i = 0; i < 6; ++i) {
      if (seen.in_contact[static_cast<std::size_t>(i)]) {
        readings.push_back({i, seen.reading[i], 0.002});
      }
    }
    const auto back = geometry::best_active_three(
        model.rig().dial_geometries(), readings, model.rig().cuboid.side_mm, seen.gamma_rad);
    if (!back) continue;
    ++solved;
    ASSERT_LT((back->pose.p_WE - seen.p_WE()).norm(), kSolved_mm);
    ASSERT_LT(std::abs(back->pose.gamma_rad - seen.gamma_rad), 1e-12);
  }
  EXPECT_GT(solved, 450);
}

TEST_P(WithMount, EveryDialReadsSixteenAtTheCentre) {
  // Default layout of spec 1: displacement 16 mm at the centre, gamma 0.
  const Vector2d q = *geometry::inverse(model.rig().robot.nominal, {28, 48}, {});
  const Prediction seen = *model.predict(model.nominal(), q, geometry::Assembly::kLeft);
  EXPECT_LT((seen.reading.array() - 16.0).abs().maxCoeff(), 1e-12 * 100);
}

INSTANTIATE_TEST_SUITE_P(
    , WithMount, testing::Values(Mount::kDistal1, Mount::kDistal2, Mount::kFree),
    [](const auto& each) {
      return each.param == Mount::kFree      ? "Free"
             : each.param == Mount::kDistal1 ? "Distal1"
                                             : "Distal2";
    });

TEST(ForwardModel, AFreeMountTakesGammaFromTheCaller) {
  geometry::Rig rig = geometry::default_rig();
  rig.cuboid.mount = Mount::kFree;
  const ForwardModel model(rig);
  const Vector2d q = *geometry::inverse(rig.robot.nominal, {25, 45}, {});
  const auto seen = model.predict(model.nominal(), q, geometry::Assembly::kLeft, 0.1);
  const auto moved = model.predict(model.nominal(), q, geometry::Assembly::kLeft, 0.1 + 1e-6);
  EXPECT_EQ(seen->gamma_rad, 0.1);
  EXPECT_LT(
      ((moved->reading - seen->reading) / 1e-6 - seen->reading_J_gamma).norm(),
      1e-4 * seen->reading_J_gamma.norm());
  EXPECT_EQ(seen->reading_J.col(model.find("clamp").value()).norm(), 0.0);
}

TEST(ForwardModel, OfPositionsHasTheRobotsParametersOnlyAndReadsWhereTheToolIs) {
  geometry::Rig rig = geometry::default_rig();
  rig.instrument.kind = "position";
  rig.dials.clear();
  rig.cuboid.reference_pose_mm = {900, 900};  // nobody needs it
  const ForwardModel model(rig);
  EXPECT_EQ(model.parameter_count(), model.robot_parameter_count());
  EXPECT_FALSE(model.find("clamp"));
  const Vector2d q = *geometry::inverse(rig.robot.nominal, {25, 45}, {});
  const auto seen = model.predict(model.nominal(), q, geometry::Assembly::kLeft);
  ASSERT_TRUE(seen);
  EXPECT_LT((seen->reading - Vector2d(25, 45)).norm(), 1e-11);
  EXPECT_EQ(seen->reading_J, seen->position_J.topRows<2>());
  EXPECT_EQ(seen->in_contact, (std::vector<bool>{true, true}));
}

/// Three slides that are not quite square: a robot in space with parameters of its own.
struct Slides {
  template <typename T>
  static geometry::Reached frames(
      const geometry::RobotModel&, std::span<const T> v, std::span<const T> q,
      geometry::Assembly, std::span<geometry::Pose<T>> X) {
    X[0].p = Eigen::Matrix<T, 3, 1>(q[0] + v[0] * q[1], q[1] + v[1] * q[2], q[2] + v[2]);
    return {};
  }
};

TEST(ForwardModel, TakesAnyRobotAndPositionsInSpace) {
  static const geometry::RobotKind& kind = geometry::add_robot_kind(
      {.name = "slides",
       .in_words = "three slides",
       .example = [] { return std::make_shared<const geometry::RobotModel>(); },
       .forward = geometry::forward_of<Slides>,
       .forward_derivative = geometry::derivative_of<Slides>});
  auto robot = std::make_shared<geometry::RobotModel>();
  robot->kind = &kind;
  for (const char* name : {"x", "y", "z"}) {
    robot->joints.push_back({name, geometry::JointKind::kPrismatic});
  }
  robot->parameters = {
      {"xy", "", "", 1.0, "rad"}, {"yz", "", "", 1.0, "rad"}, {"z0", "", "mm"}};
  robot->frames = {"E"};
  geometry::Rig rig = geometry::default_rig();
  rig.robot.model = robot;
  rig.robot.nominal = Eigen::Vector3d(0.01, -0.02, 5.0);
  rig.instrument = {.kind = "position", .dimensions = 3};
  const ForwardModel model(rig);
  ASSERT_EQ(model.parameter_count(), 3);
  const auto seen =
      model.predict(model.nominal(), Eigen::Vector3d(10, 20, 30), geometry::Assembly::kLeft);
  ASSERT_TRUE(seen);
  EXPECT_LT((seen->reading - Eigen::Vector3d(10.2, 19.4, 35)).norm(), 1e-12);
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J.diagonal() << 20, 30, 1;
  EXPECT_LT((seen->reading_J - J).norm(), 1e-12);
}

TEST(ForwardModel, SaysWhenThePoseDoesNotExist) {
  const ForwardModel model(geometry::default_rig());
  const auto seen =
      model.predict(model.nominal(), Vector2d(3.1, 0.0), geometry::Assembly::kLeft);
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error(), geometry::KinematicTrouble::kOutOfReach);
}

TEST(ForwardModel, RefusesARigWhoseReferencePoseIsOutOfReach) {
  geometry::Rig rig = geometry::default_rig();
  rig.cuboid.reference_pose_mm = {500, 0};
  EXPECT_THROW(ForwardModel{rig}, std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::simulation
