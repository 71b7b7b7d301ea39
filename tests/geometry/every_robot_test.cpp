// Laws that every robot kind of the registry keeps, and two more that are added at run time.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "geometry/by_dual.h"
#include "geometry/robot_kind.h"
#include "geometry/tool.h"
#include "tests/support/test_arms.h"

namespace sixdial::geometry {
namespace {

constexpr double kRelative = 1e-7;  // of a derivative, against fourth-order differences
constexpr double kClosure_mm = 1e-9;
constexpr int kPoses = 10'000;

std::vector<const RobotKind*> every_kind() {
  planar_arm();
  spatial_arm();
  return {robot_kinds().begin(), robot_kinds().end()};
}

struct Drawn {
  Eigen::VectorXd v;
  Eigen::VectorXd q;
  Assembly assembly;
};

class EveryRobot : public testing::TestWithParam<const RobotKind*> {
 protected:
  Drawn draw() {
    Drawn result{
        robot_.nominal, Eigen::VectorXd(robot_.joint_count()),
        static_cast<Assembly>(robot_.assemblies[count_++ % robot_.assemblies.size()].number)};
    for (Eigen::Index i = 0; i < result.v.size(); ++i) {
      result.v[i] += within(-0.5, 0.5) * robot_.parameters[static_cast<std::size_t>(i)].change;
    }
    for (Eigen::Index i = 0; i < result.q.size(); ++i) {
      const JointInfo& joint = robot_.joints[static_cast<std::size_t>(i)];
      result.q[i] = within(joint.low, joint.high);
    }
    return result;
  }
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// How the frames move when variable k (joints, then parameters) goes one unit.
  std::optional<std::vector<Eigen::Matrix<double, 6, 1>>> slope(
      const Drawn& at, int k, double step) {
    constexpr std::array kSteps{-2.0, -1.0, 1.0, 2.0};
    constexpr std::array kWeights{1.0, -8.0, 8.0, -1.0};
    Frames here(robot_);
    if (!robot_.forward(at.v, at.q, at.assembly, here.X)) return std::nullopt;
    std::vector<Eigen::Matrix<double, 6, 1>> result(
        robot_.frames.size(), Eigen::Matrix<double, 6, 1>::Zero());
    for (std::size_t s = 0; s < kSteps.size(); ++s) {
      Drawn moved = at;
      (k < robot_.joint_count() ? moved.q[k] : moved.v[k - robot_.joint_count()]) +=
          kSteps[s] * step;
      Frames there(robot_);
      if (!robot_.forward(moved.v, moved.q, moved.assembly, there.X)) return std::nullopt;
      for (std::size_t frame = 0; frame < result.size(); ++frame) {
        const Eigen::Matrix3d turn = there.X[frame].R * here.X[frame].R.transpose();
        Eigen::Matrix<double, 6, 1> change;
        change << there.X[frame].p - here.X[frame].p, (turn(2, 1) - turn(1, 2)) / 2,
            (turn(0, 2) - turn(2, 0)) / 2, (turn(1, 0) - turn(0, 1)) / 2;
        result[frame] += kWeights[s] / (12 * step) * change;
      }
    }
    return result;
  }

  /// How far the frames lie from each other and from the origin.
  static double size_mm(const Frames& frames) {
    double size = 0.0;
    for (const Pose<double>& X : frames.X) {
      size = std::max({size, X.p.norm(), (X.p - frames.X[0].p).norm()});
    }
    return size;
  }

  const RobotModel& robot_ = *GetParam()->example();
  std::mt19937_64 random_{20260301};
  std::size_t count_ = 0;
};

TEST_P(EveryRobot, SaysWhatItIs) {
  EXPECT_FALSE(GetParam()->in_words.empty());
  EXPECT_EQ(robot_.kind, GetParam());
  ASSERT_FALSE(robot_.joints.empty());
  ASSERT_FALSE(robot_.frames.empty());
  EXPECT_EQ(robot_.frames[0], "E");
  ASSERT_FALSE(robot_.assemblies.empty());
  ASSERT_FALSE(robot_.modes.empty());
  EXPECT_EQ(robot_.nominal.size(), robot_.parameter_count());
  EXPECT_TRUE(robot_.axes == 2 || robot_.axes == 3);
  for (const SaidTwice& each : robot_.said_twice) {
    EXPECT_FALSE(robot_.find_parameter(each.name)) << each.name;
  }
}

TEST_P(EveryRobot, NamesAreUniqueAndUnitsKnown) {
  std::set<std::string> names;
  for (const JointInfo& joint : robot_.joints) {
    EXPECT_TRUE(names.insert(joint.name).second) << joint.name;
    EXPECT_LT(joint.low, joint.high) << joint.name;
  }
  std::set<std::string> keys;
  for (const ParameterInfo& parameter : robot_.parameters) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
    EXPECT_TRUE(parameter.unit == "mm" || parameter.unit == "rad") << parameter.name;
    EXPECT_GT(parameter.change, 0.0) << parameter.name;
    EXPECT_GT(parameter.shown_per_unit, 0.0) << parameter.name;
    if (!parameter.rig_key.empty()) {
      EXPECT_TRUE(keys.insert(parameter.rig_key).second) << parameter.rig_key;
    }
  }
  std::set<std::string> frames(robot_.frames.begin(), robot_.frames.end());
  EXPECT_EQ(frames.size(), robot_.frames.size());
  EXPECT_EQ(find_robot_kind(GetParam()->name), GetParam());
}

TEST_P(EveryRobot, FramesAreRightHandedAndTheTwoFunctionsAgree) {
  int reached = 0;
  for (int i = 0; i < 2'000; ++i) {
    const Drawn at = draw();
    Frames plain(robot_);
    Frames with(robot_);
    const bool there = robot_.forward(at.v, at.q, at.assembly, plain.X).has_value();
    ASSERT_EQ(robot_.forward_derivative(at.v, at.q, at.assembly, with).has_value(), there);
    if (!there) continue;
    ++reached;
    for (std::size_t frame = 0; frame < plain.X.size(); ++frame) {
      const Eigen::Matrix3d& R = plain.X[frame].R;
      ASSERT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-13);
      ASSERT_GT(R.determinant(), 0.0);
      ASSERT_LT(
          (plain.X[frame].p - with.X[frame].p).norm(), 1e-12 * (1 + size_mm(plain) / 100));
      ASSERT_LT((R - with.X[frame].R).norm(), 1e-14);
    }
  }
  EXPECT_GT(reached, 1'000);
}

TEST_P(EveryRobot, DerivativesAreThoseOfTheFunction) {
  int compared = 0;
  Frames exact(robot_);  // used again for each pose, as a fit does
  for (int i = 0; i < 300; ++i) {
    const Drawn at = draw();
    if (!robot_.forward_derivative(at.v, at.q, at.assembly, exact)) continue;
    // Near a singular pose a difference says little: the derivative changes within a step.
    if (exact.by_q[0].cwiseAbs().maxCoeff() > std::max(500.0, 2.0 * size_mm(exact))) continue;
    for (int k = 0; k < robot_.joint_count() + robot_.parameter_count(); ++k) {
      const bool joint = k < robot_.joint_count();
      const auto index = static_cast<std::size_t>(joint ? k : k - robot_.joint_count());
      const bool turns = joint ? robot_.joints[index].kind == JointKind::kRevolute
                               : robot_.parameters[index].unit == "rad";
      const auto seen = slope(at, k, turns ? 2e-5 : 2e-3);
      if (!seen) continue;
      ++compared;
      for (std::size_t frame = 0; frame < seen->size(); ++frame) {
        const Eigen::Matrix<double, 6, 1> expected =
            joint ? exact.by_q[frame].col(k) : exact.by_v[frame].col(k - robot_.joint_count());
        const double size = std::max(1.0, expected.norm());
        ASSERT_LT(((*seen)[frame] - expected).norm(), kRelative * size)
            << robot_.frames[frame] << " by "
            << (joint ? robot_.joints[index].name : robot_.parameters[index].name);
      }
    }
  }
  EXPECT_GT(compared, 1'000);
}

TEST_P(EveryRobot, EveryJointAndParameterMovesAFrame) {
  Eigen::VectorXd moved =
      Eigen::VectorXd::Zero(robot_.joint_count() + robot_.parameter_count());
  for (int i = 0; i < 100; ++i) {
    const Drawn at = draw();
    Frames frames(robot_);
    if (!robot_.forward_derivative(at.v, at.q, at.assembly, frames)) continue;
    const Twists& by_q = frames.by_q[0];
    const Twists& by_v = frames.by_v[0];
    moved.head(by_q.cols()) += by_q.colwise().norm().transpose();
    moved.tail(by_v.cols()) += by_v.colwise().norm().transpose();
  }
  for (int k = 0; k < moved.size(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const auto joints = static_cast<std::size_t>(robot_.joint_count());
    EXPECT_GT(moved[k], 1e-6)
        << (index < joints ? robot_.joints[index].name
                           : robot_.parameters[index - joints].name);
  }
}

class EveryInverse : public EveryRobot {};

TEST_P(EveryInverse, ForwardOfInverseCloses) {
  int reached = 0;
  for (int i = 0; i < 3 * kPoses && reached < kPoses; ++i) {
    const Drawn at = draw();
    Frames frames(robot_);
    if (!robot_.forward(at.v, at.q, at.assembly, frames.X)) continue;
    const auto mode =
        WorkingMode(robot_.modes[static_cast<std::size_t>(i) % robot_.modes.size()].number);
    const std::span<const double> v(at.v.data(), static_cast<std::size_t>(at.v.size()));
    const std::span<const double> near(at.q.data(), static_cast<std::size_t>(at.q.size()));
    const auto q = GetParam()->inverse(robot_, v, frames.X[0], mode, near);
    if (!q) continue;
    double miss_mm = HUGE_VAL;
    for (const BranchInfo& assembly : robot_.assemblies) {
      Frames back(robot_);
      const auto closes =
          robot_.forward(at.v, *q, static_cast<Assembly>(assembly.number), back.X);
      if (closes) miss_mm = std::min(miss_mm, (back.X[0].p - frames.X[0].p).norm());
    }
    ASSERT_LT(miss_mm, kClosure_mm);
    for (Eigen::Index k = 0; k < q->size(); ++k) {
      if (robot_.joints[static_cast<std::size_t>(k)].kind != JointKind::kRevolute) continue;
      ASSERT_LE(std::abs((*q)[k] - at.q[k]), std::numbers::pi + 1e-9);
    }
    ++reached;
  }
  EXPECT_GE(reached, kPoses);
}

TEST_P(EveryInverse, APoseIsInTheModeThatItWasAskedFor) {
  const Tool tool(GetParam()->example(), robot_.axes);
  int tried = 0;
  for (int i = 0; tried < kPoses && i < 20 * kPoses; ++i) {
    const Drawn at = draw();
    const auto p_WE = tool.position(at.v, at.q, at.assembly);
    if (!p_WE) continue;
    const auto mode =
        WorkingMode(robot_.modes[static_cast<std::size_t>(i) % robot_.modes.size()].number);
    const auto q = tool.inverse(at.v, *p_WE, mode, at.q);
    if (!q) continue;
    const auto assembly = tool.assembly_at(at.v, *q, *p_WE);
    ASSERT_TRUE(assembly);
    ASSERT_EQ(tool.mode_of(at.v, *q, *assembly).value(), mode);
    ++tried;
  }
  EXPECT_GE(tried, kPoses);
}

// What a kind has for speed, or for a drawing, agrees with its frames.
TEST_P(EveryRobot, ItsShortWaysSayTheSame) {
  int reached = 0;
  for (int i = 0; reached < kPoses && i < 20 * kPoses; ++i) {
    const Drawn at = draw();
    Frames frames(robot_);
    if (!robot_.forward_derivative(at.v, at.q, at.assembly, frames)) continue;
    ++reached;
    const int link = i % static_cast<int>(robot_.frames.size() - 1) + 1;
    Eigen::Matrix2Xd J_q;
    const auto seen = planar_pose(robot_, at.v, at.q, at.assembly, link, &J_q);
    ASSERT_TRUE(seen);
    EXPECT_LT((seen->p_WE - frames.X[0].p.head<2>()).norm(), 1e-11);
    EXPECT_LT((J_q - frames.by_q[0].topRows<2>()).norm(), 1e-9);
    const Eigen::Matrix3d& R = frames.X[static_cast<std::size_t>(link)].R;
    EXPECT_LT(
        std::abs(std::remainder(
            seen->link_rad - std::atan2(R(1, 0), R(0, 0)), 2 * std::numbers::pi)),
        1e-11);
    if (GetParam()->sketch == nullptr) continue;
    const std::span<const double> v(at.v.data(), static_cast<std::size_t>(at.v.size()));
    const Sketch sketch =
        GetParam()->sketch(robot_, v, seen->p_WE, WorkingMode(robot_.modes[0].number));
    EXPECT_EQ(sketch.dots.empty(), sketch.trouble.has_value());
    if (sketch.dots.empty()) continue;
    EXPECT_EQ(sketch.dots.back().part, Sketch::Part::kTool);
    EXPECT_LT((sketch.dots.back().at - seen->p_WE).norm(), 1e-9);
  }
  EXPECT_GE(reached, kPoses);
}

INSTANTIATE_TEST_SUITE_P(, EveryRobot, testing::ValuesIn(every_kind()), [](const auto& each) {
  return std::string(each.param->name);
});

std::vector<const RobotKind*> kinds_with_inverse() {
  auto kinds = every_kind();
  std::erase_if(kinds, [](const RobotKind* kind) { return kind->inverse == nullptr; });
  return kinds;
}
INSTANTIATE_TEST_SUITE_P(
    , EveryInverse, testing::ValuesIn(kinds_with_inverse()),
    [](const auto& each) { return std::string(each.param->name); });

TEST(RobotKinds, ANameCanBeHadOnce) {
  RobotKind again = planar_arm();
  EXPECT_THROW(add_robot_kind(again), std::invalid_argument);
  again.name = "planar_arm_without_forward";
  again.forward = nullptr;
  EXPECT_THROW(add_robot_kind(again), std::invalid_argument);
  EXPECT_EQ(find_robot_kind("planar_arm_without_forward"), nullptr);
}

TEST(Dual, DerivativesAreThoseOfTheFunctions) {
  using D = Dual<2>;
  const auto function = [](const auto& x, const auto& y) {
    using std::acos, std::atan2, std::cos, std::sin, std::sqrt, std::abs;
    return sin(x) * cos(y) / sqrt(x * x + y) + atan2(x, y) - acos(x / 3.0) + abs(-x * y);
  };
  const D value = function(D(0.7, 0), D(1.3, 1));
  EXPECT_DOUBLE_EQ(value.value, function(0.7, 1.3));
  constexpr double kStep = 1e-5;
  EXPECT_NEAR(
      value.d[0], (function(0.7 + kStep, 1.3) - function(0.7 - kStep, 1.3)) / (2 * kStep),
      1e-9);
  EXPECT_NEAR(
      value.d[1], (function(0.7, 1.3 + kStep) - function(0.7, 1.3 - kStep)) / (2 * kStep),
      1e-9);
}

}  // namespace
}  // namespace sixdial::geometry
