// Deltas and a hexapod worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/robot_kind.h"
#include "geometry/tool.h"

namespace sixdial::geometry {
namespace {

constexpr double kSame_mm = 1e-9;

std::shared_ptr<const RobotModel> of(const char* kind) {
  return find_robot_kind(kind)->example();
}

// Rods of 340 mm on a radius of 172 mm: with all carriages at 400 mm the platform hangs
// sqrt(340^2 - 172^2) = 293.28 mm below them. With the nozzle at x = 86, y = 0 the tower at 90
// degrees is sqrt(86^2 + 172^2) away, 192.299 mm, the one at 330 degrees
// sqrt((148.956 - 86)^2 + 86^2) = 106.581 mm, the one at 210 degrees
// sqrt((148.956 + 86)^2 + 86^2) = 250.201 mm.
TEST(LinearDelta, StandsWhereAHandPutsIt) {
  const auto robot = of("linear_delta");
  const Tool tool(robot, 3);
  const auto below = static_cast<Assembly>(+1);
  const auto middle = tool.position(robot->nominal, Eigen::Vector3d(400, 400, 400), below);
  ASSERT_TRUE(middle);
  EXPECT_LT(
      (*middle - Eigen::Vector3d(0, 0, 400 - std::sqrt(340. * 340 - 172. * 172))).norm(),
      kSame_mm);
  const auto up = [](double away2) { return std::sqrt(340.0 * 340.0 - away2); };
  const double far = 172.0 * std::sqrt(3.0) / 2;
  const Eigen::Vector3d q(
      10 + up(86. * 86 + 172. * 172), 10 + up((far + 86) * (far + 86) + 86. * 86),
      10 + up((far - 86) * (far - 86) + 86. * 86));
  const auto at = tool.position(robot->nominal, q, below);
  ASSERT_TRUE(at);
  EXPECT_LT((*at - Eigen::Vector3d(86, 0, 10)).norm(), kSame_mm);
}

// Arms of 120 mm held out flat on a radius of 75 mm: knees at 195 mm, the platform
// sqrt(300^2 - 195^2) below the motors; hanging straight down: sqrt(300^2 - 75^2) below 120.
TEST(RotaryDelta, StandsWhereAHandPutsIt) {
  const auto robot = of("rotary_delta");
  const Tool tool(robot, 3);
  const auto below = static_cast<Assembly>(+1);
  const auto flat = tool.position(robot->nominal, Eigen::Vector3d::Zero(), below);
  ASSERT_TRUE(flat);
  EXPECT_LT(
      (*flat - Eigen::Vector3d(0, 0, -std::sqrt(300. * 300 - 195. * 195))).norm(), kSame_mm);
  const auto down =
      tool.position(robot->nominal, Eigen::Vector3d::Constant(std::acos(0.0)), below);
  ASSERT_TRUE(down);
  EXPECT_LT(
      (*down - Eigen::Vector3d(0, 0, -120 - std::sqrt(300. * 300 - 75. * 75))).norm(),
      kSame_mm);
}

// In the middle all legs are equally long: base joints at 250 mm, platform joints at 150 mm,
// 60 degrees less two times 0.2 rad apart in direction.
TEST(Stewart, StandsWhereAHandPutsIt) {
  const auto robot = of("stewart");
  const Tool tool(robot, 3);
  const double between = std::acos(-1.0) / 3 - 2 * 0.2;
  const double flat2 = 250. * 250 + 150. * 150 - 2 * 250. * 150 * std::cos(between);
  const double leg = std::sqrt(flat2 + 380. * 380);
  Eigen::VectorXd q = Eigen::VectorXd::Constant(6, leg);
  const auto middle = tool.position(robot->nominal, q, Assembly::kLeft);
  ASSERT_TRUE(middle);
  EXPECT_LT((*middle - Eigen::Vector3d(0, 0, 380)).norm(), kSame_mm);
  q.setConstant(std::sqrt(flat2 + 400. * 400));
  const auto lifted = tool.position(robot->nominal, q, Assembly::kLeft);
  ASSERT_TRUE(lifted);
  EXPECT_LT((*lifted - Eigen::Vector3d(0, 0, 400)).norm(), kSame_mm);
}

TEST(Stewart, RefusesLegsThatDoNotMeet) {
  const auto robot = of("stewart");
  const Tool tool(robot, 3);
  Eigen::VectorXd q = Eigen::VectorXd::Constant(6, 430.0);
  q[0] = 5'000.0;
  EXPECT_FALSE(tool.position(robot->nominal, q, Assembly::kLeft));
  q[0] = -1.0;
  EXPECT_EQ(
      tool.position(robot->nominal, q, Assembly::kLeft).error(),
      KinematicTrouble::kBadParameters);
}

}  // namespace
}  // namespace sixdial::geometry
