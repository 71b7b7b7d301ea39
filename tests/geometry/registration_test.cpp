// Laws of registration: any drawn motion is found exactly, in the plane and in space, with or
// without points that stand out; and of base frames: every kind of robot that has one moves it.
#include "geometry/registration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>
#include <random>

#include "geometry/base_frame.h"
#include "tests/support/test_arms.h"

namespace sixdial::geometry {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kExact = 1e-9;  // relative to 1000 mm: double precision, a few dozen flops
constexpr double kClosure_mm = 1e-6;
constexpr double kPi = std::numbers::pi;

class Registering : public testing::TestWithParam<int> {
 protected:
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  VectorXd drawn_vector(double size) {
    VectorXd v(axes());
    for (double& each : v) each = within(-size, size);
    return v;
  }
  Eigen::Index axes() const { return GetParam(); }
  /// A robot's work: 60 mm wide, anywhere on the table.
  MatrixXd cloud(Eigen::Index n) {
    const VectorXd at = drawn_vector(500.0);
    MatrixXd points(axes(), n);
    for (Eigen::Index i = 0; i < n; ++i) points.col(i) = at + drawn_vector(30.0);
    return points;
  }
  Similarity motion() {
    Similarity X = Similarity::identity(axes());
    if (axes() == 2) {
      X.R = Eigen::Rotation2Dd(within(-kPi, kPi)).toRotationMatrix();
    } else {
      const Eigen::Vector3d axis = Eigen::Vector3d(drawn_vector(1.0)).normalized();
      X.R = Eigen::AngleAxisd(within(-kPi, kPi), axis).toRotationMatrix();
    }
    X.t = drawn_vector(800.0);
    return X;
  }
  MatrixXd moved(const Similarity& X, const MatrixXd& points) {
    return (X.scale * X.R * points).colwise() + X.t;
  }
  void expect_same(const Similarity& found, const Similarity& truth) {
    EXPECT_LT((found.R - truth.R).norm(), kExact);
    EXPECT_LT((found.t - truth.t).norm(), 1000 * kExact);
    EXPECT_NEAR(found.scale, truth.scale, kExact * truth.scale);
  }

  std::mt19937_64 random_{20260302};
};

TEST_P(Registering, RecoversAnyRigidMotionExactly) {
  for (int k = 0; k < 200; ++k) {
    const MatrixXd from = cloud(3 + k % 40);
    const Similarity truth = motion();
    const auto found = register_points(from, moved(truth, from));
    ASSERT_TRUE(found);
    expect_same(found->X, truth);
    EXPECT_FALSE(found->X.mirrored());
    if (axes() == 2) {
      EXPECT_NEAR(
          std::remainder(
              found->X.turn_rad() - std::atan2(truth.R(1, 0), truth.R(0, 0)), 2 * kPi),
          0.0, kExact);
    }
  }
}

TEST_P(Registering, RecoversAUnitAndAMirroredFrame) {
  constexpr std::array kUnits{1.0 / 25.4, 1.0 / 1000.0, 0.1, 1000.0, 1.0};
  for (int k = 0; k < 200; ++k) {
    const MatrixXd from = cloud(8 + k % 40);
    Similarity truth = motion();
    truth.scale = kUnits[static_cast<std::size_t>(k) % kUnits.size()];
    if (k % 2 == 0) truth.R.col(0) *= -1.0;
    const auto found =
        register_points(from, moved(truth, from), {.may_scale = true, .may_mirror = true});
    ASSERT_TRUE(found);
    expect_same(found->X, truth);
    EXPECT_EQ(found->X.mirrored(), k % 2 == 0);
    EXPECT_TRUE(found->mirror_known);
  }
}

TEST_P(Registering, APartOfGrossRowsChangesNothing) {
  for (int k = 0; k < 60; ++k) {
    const Eigen::Index n = 15 + k;
    const MatrixXd from = cloud(n);
    const Similarity truth = motion();
    MatrixXd to = moved(truth, from);
    const Eigen::Index gross = n / 5;
    for (Eigen::Index i = 0; i < gross; ++i) {
      to.col(5 * i + k % 5) += (k % 2 == 0 ? 5.0 : 5000.0) * VectorXd::Ones(axes()) +
                               drawn_vector(k % 3 == 0 ? 1.0 : 400.0);
    }
    const auto found = register_points(from, to, {.may_scale = k % 4 == 1});
    ASSERT_TRUE(found);
    expect_same(found->X, truth);
    EXPECT_EQ(std::ranges::count(found->fits, false), gross);
  }
}

TEST_P(Registering, ScatterOfAMillimetreLeavesTheTurnWithinItsSpread) {
  for (int k = 0; k < 40; ++k) {
    const MatrixXd from = cloud(100);
    const Similarity truth = motion();
    MatrixXd to = moved(truth, from);
    std::normal_distribution<double> noise(0.0, 1.0);
    for (double& each : to.reshaped()) each += noise(random_);
    const auto found = register_points(from, to);
    ASSERT_TRUE(found);
    // 1 mm over 100 points of +-30 mm: 0.006 rad, four times that.
    EXPECT_LT((found->X.R - truth.R).norm(), 0.035);
    EXPECT_NEAR(found->rms, std::sqrt(static_cast<double>(axes())), 0.35);
  }
}

TEST_P(Registering, PointsThatTellNoTurnAreRefused) {
  const MatrixXd one_place = VectorXd::Constant(axes(), 5.0).replicate(1, 9);
  EXPECT_FALSE(register_points(one_place, one_place));
  if (axes() == 3) {
    MatrixXd line = MatrixXd::Zero(3, 9);
    line.row(0).setLinSpaced(0.0, 80.0);
    EXPECT_FALSE(register_points(line, line));
  } else {  // a line tells a turn of the plane, but not its handedness
    MatrixXd line = MatrixXd::Zero(2, 9);
    line.row(0).setLinSpaced(0.0, 80.0);
    const auto found = register_points(line, line, {.may_mirror = true});
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->mirror_known);
    EXPECT_FALSE(found->X.mirrored());
  }
}

INSTANTIATE_TEST_SUITE_P(Axes, Registering, testing::Values(2, 3));

struct BaseCase {
  const RobotKind* kind;
  int axes;
};

/// Kinds whose parameters hold the whole base, and the axes that a position of them has.
std::vector<BaseCase> bases() {
  return {{find_robot_kind("five_bar"), 2}, {&planar_arm(), 2}, {&spatial_arm(), 3}};
}

class EveryBase : public testing::TestWithParam<BaseCase> {};

TEST_P(EveryBase, MovesByAnyTurnAndShiftWithoutAnyOtherChange) {
  const auto robot = GetParam().kind->example();
  const Tool tool(robot, GetParam().axes);
  std::mt19937_64 random(7);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<JointPose> poses;
  while (poses.size() < 60) {
    JointPose pose{
        VectorXd(robot->joint_count()),
        static_cast<Assembly>(robot->assemblies.front().number)};
    for (Eigen::Index i = 0; i < pose.q.size(); ++i) {
      const JointInfo& joint = robot->joints[static_cast<std::size_t>(i)];
      pose.q[i] = within(joint.low, joint.high);
    }
    if (tool.derivative(robot->nominal, pose.q, pose.assembly)) poses.push_back(pose);
  }
  const std::span<const JointPose> seen = std::span(poses).first(40);
  int moved_bases = 0;
  for (const double turn : {0.0, 0.02, -1.0, kPi / 2, 3.0, kPi}) {
    Similarity X = Similarity::identity(tool.axes());
    if (tool.axes() == 2) {
      X.R = Eigen::Rotation2Dd(turn).toRotationMatrix();
    } else {
      X.R =
          Eigen::AngleAxisd(turn, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
    }
    for (double& each : X.t) each = within(-600.0, 600.0);
    const auto v = with_base_moved(tool, robot->nominal, X, seen);
    ASSERT_TRUE(v) << turn;
    for (const JointPose& pose : poses) {
      const auto before = tool.position(robot->nominal, pose.q, pose.assembly);
      const auto after = tool.position(*v, pose.q, pose.assembly);
      ASSERT_TRUE(before && after);
      EXPECT_LT((*after - X(*before)).norm(), kClosure_mm);
    }
    ++moved_bases;
  }
  EXPECT_EQ(moved_bases, 6);
}

std::string name_of(const testing::TestParamInfo<BaseCase>& each) {
  return std::string(each.param.kind->name);
}
INSTANTIATE_TEST_SUITE_P(Kinds, EveryBase, testing::ValuesIn(bases()), name_of);

TEST(BaseFrame, OfAFiveBarIsItsOriginAndItsTurn) {
  const auto robot = find_robot_kind("five_bar")->example();
  const Tool tool(robot, 2);
  std::vector<JointPose> poses;
  for (double x = 16; x <= 40; x += 6) {
    for (double y = 30; y <= 66; y += 9) {
      const auto q = tool.inverse(robot->nominal, Eigen::Vector2d(x, y), WorkingMode{});
      ASSERT_TRUE(q);
      poses.push_back({*q, *tool.assembly_at(robot->nominal, *q, Eigen::Vector2d(x, y))});
    }
  }
  Similarity X = Similarity::identity(2);
  X.R = Eigen::Rotation2Dd(kPi).toRotationMatrix();
  X.t = Eigen::Vector2d(3.0, -250.0);
  const auto v = with_base_moved(tool, robot->nominal, X, poses);
  ASSERT_TRUE(v);
  for (Eigen::Index i = 0; i < v->size(); ++i) {
    const std::string& name = robot->parameters[static_cast<std::size_t>(i)].name;
    const bool of_the_base = name == "x0" || name == "y0" || name == "alpha";
    if (!of_the_base) {
      EXPECT_EQ((*v)[i], robot->nominal[i]) << name;
    }
  }
  EXPECT_NEAR(std::abs((*v)[*robot->find_parameter("alpha")]), kPi, 1e-9);
}

TEST(BaseFrame, AMirroredFrameIsNoMotionOfTheBase) {
  const auto robot = find_robot_kind("five_bar")->example();
  const Tool tool(robot, 2);
  const auto q = tool.inverse(robot->nominal, Eigen::Vector2d(28, 48), WorkingMode{});
  ASSERT_TRUE(q);
  Similarity X = Similarity::identity(2);
  X.R(1, 1) = -1.0;
  const std::vector<JointPose> poses{{*q, Assembly::kLeft}};
  EXPECT_FALSE(with_base_moved(tool, robot->nominal, X, poses));
}

}  // namespace
}  // namespace sixdial::geometry
