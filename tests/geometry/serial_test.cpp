// Arms: poses of other people's arms as orocos-kdl computes them, parameters that say the same
// twice, URDFs.
#include "geometry/robots/serial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <chrono>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <numbers>
#include <random>

#include "geometry/by_dual.h"
#include "geometry/robots/serial_chain.h"
#include "geometry/tool.h"
#include "geometry/units.h"
#include "tests/geometry/urdf_texts.h"

namespace sixdial::geometry {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kRight_rad = std::numbers::pi / 2;
constexpr double kSame_mm = 1e-10;
constexpr double kSame = 1e-13;

struct DhRow {
  double a_mm, alpha_rad, d_mm, theta_rad;
};
SerialRobot arm_of(const std::vector<DhRow>& rows, RowForm form) {
  SerialRobot arm;
  for (const DhRow& row : rows) {
    SerialRow each{.name = "q" + std::to_string(arm.rows.size() + 1), .form = form};
    each.a_mm = row.a_mm;
    each.alpha_rad = row.alpha_rad;
    each.d_mm = row.d_mm;
    each.theta_rad = row.theta_rad;
    arm.rows.push_back(each);
  }
  return arm;
}
const std::vector<DhRow> kUr10{{0, kRight_rad, 127.3, 0},  {-612, 0, 0, 0},
                               {-572.3, 0, 0, 0},          {0, kRight_rad, 163.941, 0},
                               {0, -kRight_rad, 115.7, 0}, {0, 0, 92.2, 0}};
// Franka Emika's own modified rows.
const std::vector<DhRow> kPanda{
    {0, 0, 333, 0},           {0, -kRight_rad, 0, 0},       {0, kRight_rad, 316, 0},
    {82.5, kRight_rad, 0, 0}, {-82.5, -kRight_rad, 384, 0}, {0, kRight_rad, 0, 0},
    {88, kRight_rad, 0, 0}};
// As Corke's toolbox has them; lengths of Unimation's manual.
const std::vector<DhRow> kPuma560{{0, kRight_rad, 0, 0},          {431.8, 0, 0, 0},
                                  {20.3, -kRight_rad, 150.05, 0}, {0, kRight_rad, 431.8, 0},
                                  {0, -kRight_rad, 0, 0},         {0, 0, 0, 0}};

KDL::Chain kdl_chain(const std::vector<DhRow>& rows, RowForm form) {
  KDL::Chain chain;
  for (const DhRow& row : rows) {
    if (form == RowForm::kDh) {
      chain.addSegment(KDL::Segment(
          KDL::Joint(KDL::Joint::RotZ),
          KDL::Frame::DH(row.a_mm, row.alpha_rad, row.d_mm, row.theta_rad)));
    } else {
      chain.addSegment(KDL::Segment(
          KDL::Joint(KDL::Joint::None),
          KDL::Frame::DH_Craig1989(row.a_mm, row.alpha_rad, 0.0, 0.0)));
      chain.addSegment(KDL::Segment(
          KDL::Joint(KDL::Joint::RotZ),
          KDL::Frame::DH_Craig1989(0.0, 0.0, row.d_mm, row.theta_rad)));
    }
  }
  return chain;
}

struct Named {
  const char* name;
  const std::vector<DhRow>* rows;
  RowForm form;
};

class ArmOfOthers : public testing::TestWithParam<Named> {};

TEST_P(ArmOfOthers, StandsWhereOrocosKdlPutsIt) {
  const auto robot = serial_model(arm_of(*GetParam().rows, GetParam().form));
  const KDL::Chain chain = kdl_chain(*GetParam().rows, GetParam().form);
  KDL::ChainFkSolverPos_recursive solver(chain);
  std::mt19937_64 random(14);
  std::uniform_real_distribution<double> angle(-3.1, 3.1);
  for (int i = 0; i < 1'000; ++i) {
    VectorXd q(robot->joint_count());
    KDL::JntArray joints(static_cast<unsigned>(q.size()));
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      q[k] = angle(random);
      joints(static_cast<unsigned>(k)) = q[k];
    }
    KDL::Frame theirs;
    ASSERT_GE(solver.JntToCart(joints, theirs), 0);
    Frames ours(*robot);
    ASSERT_TRUE(robot->forward(robot->nominal, q, Assembly::kLeft, ours.X));
    for (int row = 0; row < 3; ++row) {
      ASSERT_LT(std::abs(theirs.p[row] - ours.X[0].p[row]), kSame_mm);
      for (int column = 0; column < 3; ++column) {
        ASSERT_LT(std::abs(theirs.M(row, column) - ours.X[0].R(row, column)), kSame);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , ArmOfOthers,
    testing::Values(
        Named{"UR10", &kUr10, RowForm::kDh}, Named{"Panda", &kPanda, RowForm::kModifiedDh},
        Named{"Puma560", &kPuma560, RowForm::kDh}),
    [](const auto& each) { return std::string(each.param.name); });

/// Effects of all parameters on many poses; `rows` 3: on places alone.
Eigen::VectorXd singular_values(const RobotModel& robot, int rows) {
  std::mt19937_64 random(3);
  Eigen::MatrixXd A(100 * rows, robot.parameter_count());
  Frames at(robot);
  for (int i = 0; i < 100; ++i) {
    VectorXd q(robot.joint_count());
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      const JointInfo& joint = robot.joints[static_cast<std::size_t>(k)];
      q[k] = std::uniform_real_distribution<double>(joint.low, joint.high)(random);
    }
    EXPECT_TRUE(robot.forward_derivative(robot.nominal, q, Assembly::kLeft, at));
    for (Eigen::Index k = 0; k < A.cols(); ++k) {
      Eigen::Matrix<double, 6, 1> twist = at.by_v[0].col(k);
      twist.tail<3>() *= 500.0;
      A.block(100 * 0 + i * rows, k, rows, 1) =
          twist.head(rows) * robot.parameters[static_cast<std::size_t>(k)].change;
    }
  }
  return Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues();
}

// 4 numbers a revolute joint and 6 in all, for a pose; a place lacks the tool's three turns.
TEST(Serial, ItsParametersAreIndependentAndAsManyAsTheArmHas) {
  for (const bool frame : {false, true}) {
    for (const auto& [rows, form] :
         {std::pair{&kUr10, RowForm::kDh},
          {&kPuma560, RowForm::kDh},
          {&kPanda, RowForm::kModifiedDh}}) {
      SerialRobot arm = arm_of(*rows, form);
      arm.tool_is_frame = frame;
      arm.tool_mm = {10, 20, 100};
      const auto robot = serial_model(arm);
      const int n = static_cast<int>(rows->size());
      EXPECT_EQ(robot->parameter_count(), 4 * n + 6 - (frame ? 0 : 3));
      const VectorXd independent = singular_values(*robot, frame ? 6 : 3);
      EXPECT_LT(independent[0] / independent[independent.size() - 1], 1e4);
      // All of them say no more.
      arm.all_parameters = true;
      const auto all = serial_model(arm);
      EXPECT_GT(all->parameter_count(), robot->parameter_count());
      EXPECT_TRUE(all->said_twice.empty());
      const VectorXd values = singular_values(*all, frame ? 6 : 3);
      EXPECT_LT(values[robot->parameter_count()], 1e-9 * values[0]);
      EXPECT_GT(values[robot->parameter_count() - 1], 1e-5 * values[0]);
      EXPECT_EQ(
          robot->said_twice.size(),
          static_cast<std::size_t>(all->parameter_count() - robot->parameter_count()));
    }
  }
}

// A tool that the rig file leaves at zero may be anywhere: nothing is left out for its sake.
TEST(Serial, ATwoAxisPositionerWithoutAToolKeepsWhatATargetShows) {
  SerialRobot arm = arm_of({{0, kRight_rad, 0, 0}, {0, 0, 0, 0}}, RowForm::kDh);
  const auto robot = serial_model(arm);
  EXPECT_EQ(robot->parameter_count(), 4 * 2 + 3);
  for (const char* const name : {"tool_x", "tool_y", "tool_z", "a1", "alpha1"}) {
    EXPECT_TRUE(robot->find_parameter(name)) << name;
  }
}

TEST(Serial, SaysBetweenWhichNumbersTheDataCannotChoose) {
  SerialRobot arm = arm_of(kUr10, RowForm::kDh);
  arm.tool_mm = {10, 20, 100};
  const auto robot = serial_model(arm);
  const auto by = [&](const std::string& name) {
    for (const SaidTwice& each : robot->said_twice) {
      if (each.name == name) return each.by;
    }
    return std::string("not said twice");
  };
  EXPECT_EQ(by("d1"), "base_z");
  EXPECT_EQ(by("theta1"), "base_rz");
  EXPECT_EQ(by("d6"), "tool_z");
  EXPECT_EQ(by("d2"), "d4");  // three parallel axes
  EXPECT_EQ(by("d3"), "d4");
  EXPECT_TRUE(robot->find_parameter("beta2"));
  EXPECT_TRUE(robot->find_parameter("beta3"));
}

TEST(Serial, DerivativesAreThoseOfDualNumbersThroughTheWholeArm) {
  std::vector<std::shared_ptr<const RobotModel>> arms{
      find_robot_kind("serial")->example(), serial_model(arm_of(kPanda, RowForm::kModifiedDh))};
  const auto urdf = read_urdf(kGripperUrdf, "world", "finger_tip");
  ASSERT_TRUE(urdf) << urdf.error();
  SerialRobot all = *urdf;
  all.all_parameters = true;
  all.tool_is_frame = true;
  arms.push_back(serial_model(*urdf));
  arms.push_back(serial_model(all));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  for (const auto& robot : arms) {
    Frames fast(*robot);
    Frames whole(*robot);
    for (int i = 0; i < 200; ++i) {
      VectorXd q(robot->joint_count());
      for (double& each : q) each = 2.0 * draw(random);
      VectorXd v = robot->nominal;
      for (Eigen::Index k = 0; k < v.size(); ++k) {
        v[k] += draw(random) * robot->parameters[static_cast<std::size_t>(k)].change;
      }
      const std::span<const double> values(v.data(), static_cast<std::size_t>(v.size()));
      const std::span<const double> joints(q.data(), static_cast<std::size_t>(q.size()));
      ASSERT_TRUE(robot->forward_derivative(v, q, Assembly::kLeft, fast));
      ASSERT_TRUE(
          derivative_of<serial_chain::Serial>(*robot, values, joints, Assembly::kLeft, whole));
      for (std::size_t frame = 0; frame < fast.X.size(); ++frame) {
        ASSERT_LT((fast.X[frame].p - whole.X[frame].p).norm(), 1e-10);
        ASSERT_LT((fast.by_q[frame] - whole.by_q[frame]).norm(), 1e-9);
        ASSERT_LT((fast.by_v[frame] - whole.by_v[frame]).norm(), 1e-9);
      }
    }
  }
}

// The inverse from far away, and from nowhere.
TEST(Serial, TheInverseClosesFromAnywhere) {
  const auto robot = find_robot_kind("serial")->example();
  const std::span<const double> v(
      robot->nominal.data(), static_cast<std::size_t>(robot->nominal.size()));
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> angle(-2.0, 2.0);
  constexpr int kTried = 2'000;
  int reached = 0;
  for (int i = 0; i < kTried; ++i) {
    VectorXd q(6);
    VectorXd near(6);
    for (Eigen::Index k = 0; k < 6; ++k) {
      q[k] = angle(random);
      near[k] = q[k] + 0.3 * angle(random);
    }
    Frames at(*robot);
    ASSERT_TRUE(robot->forward(robot->nominal, q, Assembly::kLeft, at.X));
    const std::span<const double> start =
        i % 2 == 0 ? std::span<const double>(near.data(), 6) : std::span<const double>();
    const auto found = robot->kind->inverse(*robot, v, at.X[0], WorkingMode(), start);
    if (!found) continue;
    ++reached;
    Frames back(*robot);
    ASSERT_TRUE(robot->forward(robot->nominal, *found, Assembly::kLeft, back.X));
    ASSERT_LT((back.X[0].p - at.X[0].p).norm(), 1e-9);
    ASSERT_LT((back.X[0].R - at.X[0].R).norm(), 1e-11);
  }
  EXPECT_GT(reached, kTried * 99 / 100);
}

TEST(Serial, AnArmOfTwoJointsReachesWhatItCanAndRefusesTheRest) {
  SerialRobot arm = arm_of({{0, kRight_rad, 100, 0}, {200, 0, 0, 0}}, RowForm::kDh);
  const auto robot = serial_model(arm);
  const Tool tool(robot, 3);
  const Eigen::Vector2d q(0.4, -0.7);
  const auto p_WE = tool.position(robot->nominal, q, Assembly::kLeft);
  ASSERT_TRUE(p_WE);
  const auto back = tool.inverse(robot->nominal, *p_WE, WorkingMode());
  ASSERT_TRUE(back);
  const auto again = tool.position(robot->nominal, *back, Assembly::kLeft);
  EXPECT_LT((*again - *p_WE).norm(), 1e-9);
  EXPECT_EQ(
      tool.inverse(robot->nominal, Vector3d(150, 0, 100), WorkingMode()).error(),
      KinematicTrouble::kOutOfReach);
}

TEST(Urdf, FixedAndMimicJointsCount) {
  const auto arm = read_urdf(kGripperUrdf, "world", "finger_tip");
  ASSERT_TRUE(arm) << arm.error();
  ASSERT_EQ(arm->rows.size(), 3U);
  EXPECT_EQ(arm->rows[0].name, "lift");
  EXPECT_EQ(arm->rows[0].kind, JointKind::kPrismatic);
  EXPECT_DOUBLE_EQ(arm->rows[0].low.value(), 0.0);
  EXPECT_DOUBLE_EQ(arm->rows[0].high.value(), 250.0);
  EXPECT_EQ(arm->rows[2].follows, "knuckle");
  EXPECT_DOUBLE_EQ(arm->rows[2].ratio, -0.5);
  const auto robot = serial_model(*arm);
  ASSERT_EQ(robot->joint_count(), 2);
  EXPECT_EQ(robot->joints[1].name, "knuckle");
  // By hand: lift 100 mm above the table plate (20 mm), then 200 mm along x, knuckle 90 degrees
  // up, 50 mm, finger back by 45 degrees less 0.1 rad, 30 mm.
  const Tool tool(robot, 3);
  const auto at =
      tool.position(robot->nominal, Eigen::Vector2d(100.0, kRight_rad), Assembly::kLeft);
  ASSERT_TRUE(at);
  const double finger = kRight_rad - 0.5 * kRight_rad + 0.1;
  const Vector3d by_hand(
      200.0 + 30.0 * std::cos(finger), 0.0, 20.0 + 100.0 + 50.0 + 30.0 * std::sin(finger));
  EXPECT_LT((*at - by_hand).norm(), 1e-9);
}

TEST(Urdf, SaysWhatIsWrong) {
  const auto error = [](std::string_view text, const char* base, const char* tip) {
    const auto arm = read_urdf(text, base, tip);
    return arm ? std::string("read") : arm.error();
  };
  EXPECT_THAT(error("<robot", "", ""), HasSubstr("is no URDF"));
  EXPECT_THAT(error("", "", ""), HasSubstr("is no URDF"));
  EXPECT_THAT(error(kGripperUrdf, "wrld", "finger_tip"), HasSubstr("no link 'wrld'"));
  EXPECT_THAT(error(kGripperUrdf, "", ""), HasSubstr("camera, finger_tip"));
  EXPECT_THAT(error(kGripperUrdf, "finger_tip", "camera"), HasSubstr("does not hang on"));
  EXPECT_THAT(error(kGripperUrdf, "world", "plate"), HasSubstr("no joint moves"));
}

std::string with(std::string_view text, std::string_view old, std::string_view other) {
  std::string changed(text);
  const std::size_t at = changed.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return changed.replace(at, old.size(), other);
}

TEST(Urdf, RefusesANameThatNoColumnCanHave) {
  for (const char* const name : {"", "the knuckle", "a,b", "say &quot;a&quot;", "a&#9;b"}) {
    SCOPED_TRACE(name);
    const std::string joint =
        std::string("<joint name=\"").append(name).append("\" type=\"rev");
    const auto arm = read_urdf(
        with(kGripperUrdf, R"(<joint name="knuckle" type="rev)", joint), "world", "finger_tip");
    EXPECT_FALSE(arm);
  }
  const auto arm =
      read_urdf(with(kGripperUrdf, R"("lift")", R"("the lift")"), "world", "finger_tip");
  ASSERT_FALSE(arm);
  EXPECT_THAT(arm.error(), HasSubstr("a joint 'the lift', which cannot name a column"));
}

TEST(Urdf, TakesAnAxisOfAnyLength) {
  const auto arm = read_urdf(
      with(
          kGripperUrdf, R"(xyz="0 0 1"/>
    <limit lower="0" upper="0.25")",
          R"(xyz="0 3e200 4e200"/>
    <limit lower="0" upper="0.25")"),
      "world", "finger_tip");
  ASSERT_TRUE(arm) << arm.error();
  EXPECT_LT((arm->rows[0].axis - Vector3d(0.0, 0.6, 0.8)).norm(), 1e-15);
}

TEST(Urdf, LimitsWithoutARangeAreNone) {
  const auto arm = read_urdf(
      with(kGripperUrdf, R"(upper="0.25")", R"(upper="5e-324")"), "world", "finger_tip");
  ASSERT_TRUE(arm) << arm.error();
  EXPECT_FALSE(arm->rows[0].low);
  EXPECT_FALSE(arm->rows[0].high);
}

}  // namespace
}  // namespace sixdial::geometry
