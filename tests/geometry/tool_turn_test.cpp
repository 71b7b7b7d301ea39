// The tool's frame on the last link, and which robots can turn a tool any way.
#include "geometry/tool_turn.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/robots/serial.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kTurn_rad = 1e-8;  // of with_tool_turned's closure over its lever
constexpr double kPlace_mm = 1e-5;

SerialRobot ur10() {
  const auto example = find_robot_kind("serial")->example();
  return serial_robot(*example, example->nominal);
}

std::shared_ptr<const RobotModel> with_frame(bool all_parameters = false) {
  SerialRobot arm = ur10();
  arm.tool_is_frame = true;
  arm.all_parameters = all_parameters;
  return serial_model(arm);
}

class ToolTurn : public ::testing::TestWithParam<Vector3d> {};

TEST_P(ToolTurn, TurnsTheToolOnItsLinkAndLeavesItsPoint) {
  const Matrix3d R = turned_by<double>(GetParam());
  for (const bool all : {false, true}) {
    const auto robot = with_frame(all);
    const auto turned = with_tool_turned(*robot, robot->nominal, R);
    ASSERT_TRUE(turned);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> draw(-3.0, 3.0);
    std::vector<Pose<double>> before(robot->frames.size()), after(robot->frames.size());
    for (int i = 0; i < 50; ++i) {
      VectorXd q(6);
      for (double& each : q) each = draw(random);
      ASSERT_TRUE(robot->forward(robot->nominal, q, Assembly::kLeft, before));
      ASSERT_TRUE(robot->forward(*turned, q, Assembly::kLeft, after));
      EXPECT_LT((before[0].p - after[0].p).norm(), kPlace_mm);
      EXPECT_LT(turn_between(before[0].R * R, after[0].R), kTurn_rad);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , ToolTurn,
    ::testing::Values(
        Vector3d(0, 0, 0), Vector3d(0.01, 0, 0), Vector3d(0.3, -0.6, 1.9), Vector3d(0, 3.1, 0),
        Vector3d(-1.2, 1.2, -1.2)),
    [](const auto& each) { return "Turn" + std::to_string(each.index); });

TEST(ToolTurnOfKinds, AHexapodsPlatformTakesItToo) {
  const auto robot = find_robot_kind("stewart")->example();
  EXPECT_TRUE(turns_its_tool(*robot, robot->nominal));
  EXPECT_TRUE(reaches_any_turn(*robot, robot->nominal));
}

TEST(ToolTurnOfKinds, OnlyParametersOfAFrameTurnATool) {
  const auto frame = with_frame();
  EXPECT_TRUE(turns_its_tool(*frame, frame->nominal));
  const auto point = serial_model(ur10());
  EXPECT_FALSE(turns_its_tool(*point, point->nominal));
  const Matrix3d R = turned_by<double>(Vector3d(0.1, 0.2, 0.3));
  EXPECT_FALSE(with_tool_turned(*point, point->nominal, R));
}

TEST(ToolTurnOfKinds, SixIndependentDirectionsAreNeeded) {
  const auto six = with_frame();
  EXPECT_TRUE(reaches_any_turn(*six, six->nominal));
  SerialRobot five = ur10();
  five.rows.pop_back();
  const auto short_arm = serial_model(five);
  EXPECT_FALSE(reaches_any_turn(*short_arm, short_arm->nominal));
  // Six joints whose axes are all parallel stay in a plane.
  SerialRobot flat = ur10();
  for (SerialRow& row : flat.rows) {
    row.alpha_rad = 0.0;
    row.a_mm = 200.0;
  }
  const auto snake = serial_model(flat);
  EXPECT_FALSE(reaches_any_turn(*snake, snake->nominal));
  for (const char* const kind : {"five_bar", "linear_delta", "rotary_delta"}) {
    const auto robot = find_robot_kind(kind)->example();
    EXPECT_FALSE(reaches_any_turn(*robot, robot->nominal)) << kind;
    EXPECT_FALSE(turns_its_tool(*robot, robot->nominal)) << kind;
  }
}

TEST(ToolTurnOfKinds, JointValuesOfAPosePutTheToolThere) {
  const auto robot = with_frame();
  VectorXd q(6);
  q << 0.3, -1.1, 1.2, -0.4, 0.9, 0.2;
  std::vector<Pose<double>> X(robot->frames.size());
  ASSERT_TRUE(robot->forward(robot->nominal, q, Assembly::kLeft, X));
  const auto found =
      joints_for_pose(*robot, robot->nominal, X[0], WorkingMode(0), VectorXd(q.array() + 0.2));
  ASSERT_TRUE(found);
  EXPECT_LT((*found - q).norm(), 1e-7);
}

}  // namespace
}  // namespace sixdial::geometry
