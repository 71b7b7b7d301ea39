// The mock arm in time: it moves as it is told, and its wires are as long as they are.
#include "mock_devices/arm_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mock_devices/mock_arm.h"

namespace sixdial::mock_devices {
namespace {

constexpr double kWire_mm = 0.11;  // five deviations of the noise, and a step of the display

ArmWorld quiet_arm() {
  ArmWorld world = drawn_arm(11, 6);
  world.noise_mm = 0.02;
  world.warm_up_c = 0.0;
  return world;
}

class ArmBenchTest : public testing::Test {
 protected:
  double now_s_ = 0.0;
  ArmBench bench_{drawn_setting(quiet_arm()), [this] { return now_s_; }};
};

TEST_F(ArmBenchTest, StandsIdleThenMovesAndArrives) {
  EXPECT_EQ(bench_.robot().state, MotionState::kIdle);
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(6, 0.4);
  ASSERT_TRUE(bench_.start_move(target, 100));
  now_s_ = 0.1;
  EXPECT_EQ(bench_.robot().state, MotionState::kMoving);
  now_s_ = 5.0;
  EXPECT_EQ(bench_.robot().state, MotionState::kInPosition);
  EXPECT_EQ(bench_.robot().moves_started, 1);
  EXPECT_LT((bench_.robot().q_rad - target).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_F(ArmBenchTest, WiresShowTheirLengthFromWhereTheToolIs) {
  const auto panel = bench_.panel("modbus-tcp");
  ASSERT_EQ(panel->dial_count(), 6u);
  ASSERT_TRUE(bench_.start_move(Eigen::VectorXd::Constant(6, -0.5), 100));
  now_s_ = 10.0;
  for (std::size_t wire = 0; wire < 6; ++wire) {
    const ShownDial shown = panel->show(wire);
    EXPECT_TRUE(shown.in_contact);
    EXPECT_NEAR(shown.value, bench_.true_length_mm(wire), kWire_mm);
    EXPECT_GT(shown.value, 100.0);
  }
}

TEST_F(ArmBenchTest, IsStoppedOnItsWayAndRefusesWhatIsOutOfRange) {
  ASSERT_TRUE(bench_.start_move(Eigen::VectorXd::Constant(6, 1.0), 10));
  now_s_ = 1.0;
  bench_.stop();
  const Eigen::VectorXd there = bench_.robot().q_rad;
  EXPECT_LT(there[0], 0.9);
  now_s_ = 60.0;
  EXPECT_EQ(bench_.robot().q_rad, there);
  EXPECT_EQ(bench_.robot().fault, RobotFault::kStopped);
  EXPECT_FALSE(bench_.start_move(Eigen::VectorXd::Constant(6, 9.0), 100));
  EXPECT_EQ(bench_.robot().fault, RobotFault::kOutOfReach);
  EXPECT_TRUE(bench_.start_move(Eigen::VectorXd::Constant(6, 0.1), 100));
  EXPECT_EQ(bench_.robot().fault, RobotFault::kNone);
}

// What the live arm shows is what the same arm shows in a session that is written at once.
TEST(ArmBench, TheHiddenCauseIsThatOfTheWrittenSessions) {
  ArmWorld world = quiet_arm();
  world.effects = {make_arm_effect(world, "joint_backlash", "joint2", 1e-3)};
  double now_s = 0.0;
  ArmBench bench(drawn_setting(world), [&] { return now_s; });
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(6, 0.3);
  const auto length_coming_from = [&](double from) {
    bench.start_move(Eigen::VectorXd::Constant(6, from), 100);
    now_s += 20.0;
    bench.start_move(target, 100);
    now_s += 20.0;
    return bench.true_length_mm(0);
  };
  EXPECT_GT(std::abs(length_coming_from(0.2) - length_coming_from(0.4)), 0.02);
}

TEST(MockArm, EffectsAreReadFromTextOrDrawn) {
  const ArmWorld world = quiet_arm();
  const ArmEffect said = parse_arm_effect(world, "joint_backlash:joint2:0.0006", 1);
  EXPECT_EQ(said.where, "joint2");
  EXPECT_EQ(said.amplitude, 0.0006);
  EXPECT_EQ(parse_arm_effect(world, "joint_coupling:joint4,joint5", 1).where, "joint4,joint5");
  EXPECT_EQ(parse_arm_effect(world, "joint_gain", 1).cause, "joint_gain");
  EXPECT_THROW((void)parse_arm_effect(world, "joint_rust", 1), std::invalid_argument);
  EXPECT_THROW((void)parse_arm_effect(world, "joint_gain:joint9", 1), std::invalid_argument);
  EXPECT_THROW(
      (void)parse_arm_effect(world, "joint_gain:joint1:much", 1), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::mock_devices
