// The rig in time: moves, settling, hold, hysteresis, noise. Time is handed in, nothing waits.
#include "mock_devices/live_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "mock_devices/motion.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

World world_with(const DialHabits& dials) {
  World world;
  world.robot = drawn_robot(world.rig, 3);
  world.dials = dials;
  return world;
}

Vector2d angles_at(const World& world, const Vector2d& target_mm) {
  return geometry::inverse(
             world.rig.robot.nominal, target_mm, world.rig.robot.working_mode,
             Vector2d(1.3, 3.0))
      .value();
}

TEST(Move, IsATrapezoidThatBothJointsShare) {
  const Move move(
      Vector2d(0, 1), Vector2d(0.8, 0.6), 10.0,
      {.speed_rad_s = 0.8, .acceleration_rad_s2 = 4.0}, 0.5);
  // 0.4 rad/s reached in 0.1 s: 0.8 / 0.4 + 0.1 s in all.
  EXPECT_NEAR(move.end_s() - move.start_s(), 2.1, 1e-12);
  EXPECT_EQ(move.at(9.0), Vector2d(0, 1));
  EXPECT_EQ(move.at(13.0), Vector2d(0.8, 0.6));
  EXPECT_NEAR(move.at(10.05)[0], 4.0 * 0.05 * 0.05 / 2, 1e-12);
  EXPECT_NEAR(move.at(11.05)[0], 0.4, 1e-12);
  EXPECT_NEAR(move.at(11.05)[1], 0.8, 1e-12);
  double before = -1.0;
  for (double t = 10.0; t < 12.2; t += 0.01) {
    EXPECT_GE(move.at(t)[0], before);
    before = move.at(t)[0];
  }
}

TEST(Move, StopsWhereItIsCutAndStillKnowsHowItGotThere) {
  Move move(Vector2d(0, 0), Vector2d(0.8, 0), 0.0, {}, 1.0);
  const Vector2d early = move.at(0.2);
  const Vector2d there = move.at(0.5);
  move.cut(0.5);
  EXPECT_EQ(move.at(5.0), there);
  EXPECT_EQ(move.at(0.2), early);
  EXPECT_EQ(move.end_s(), 0.5);
}

TEST(LiveRig, StandsIdleAtTheReferencePoseUntilTold) {
  const World world = world_with({});
  LiveRig rig(world);
  const RobotReport report = rig.robot(5.0);
  EXPECT_EQ(report.state, MotionState::kIdle);
  EXPECT_EQ(report.moves_started, 0);
  EXPECT_LT((report.q_rad - angles_at(world, {28, 48})).norm(), 1e-12);
}

TEST(LiveRig, MovesReportsAndArrivesOnTheEncoderGrid) {
  const World world = world_with({});
  LiveRigHabits habits;
  LiveRig rig(world, habits);
  const Vector2d target = angles_at(world, {20, 60});
  ASSERT_TRUE(rig.start_move(target, 100, 1.0));
  EXPECT_EQ(rig.robot(1.05).state, MotionState::kMoving);
  const RobotReport report = rig.robot(20.0);
  EXPECT_EQ(report.state, MotionState::kInPosition);
  EXPECT_EQ(report.moves_started, 1);
  EXPECT_LT((report.q_rad - target).cwiseAbs().maxCoeff(), 0.51 * habits.encoder_step_rad);
  const TruePose pose = rig.true_pose(20.0);
  EXPECT_LT((pose.p_WE - Vector2d(20, 60)).norm(), 5.0);
  EXPECT_GT((pose.p_WE - Vector2d(20, 60)).norm(), 0.1);  // the true robot is not the nominal
}

TEST(LiveRig, RefusesATargetOutOfReachAndStays) {
  const World world = world_with({});
  LiveRig rig(world);
  const Vector2d before = rig.robot(1.0).q_rad;
  EXPECT_FALSE(rig.start_move({3.0, 0.0}, 100, 1.0));
  RobotReport report = rig.robot(2.0);
  EXPECT_EQ(report.state, MotionState::kFault);
  EXPECT_EQ(report.fault, RobotFault::kOutOfReach);
  EXPECT_EQ(report.moves_started, 0);
  EXPECT_EQ(report.q_rad, before);
  ASSERT_TRUE(rig.start_move(angles_at(world, {25, 50}), 100, 3.0));
  EXPECT_EQ(rig.robot(3.01).fault, RobotFault::kNone);
}

TEST(LiveRig, RefusesAWayThroughASingularityWithinOneWorkingMode) {
  const World world = world_with({});
  LiveRig rig(world);
  // The same pose by a full turn of joint 2: in reach at its end, not on the way.
  const Vector2d q = angles_at(world, {22, 40});
  ASSERT_GT(q[1], 3.2);
  EXPECT_FALSE(rig.start_move(q - Vector2d(0, 2 * std::numbers::pi), 100, 1.0));
  EXPECT_TRUE(rig.start_move(q, 100, 2.0));
}

TEST(LiveRig, ChangesItsWorkingModeWithTheToolOnTheDialsSide) {
  const World world = world_with(kIdealDials);
  LiveRig rig(world);
  double time_s = 1.0;
  for (const geometry::WorkingMode mode : geometry::kWorkingModes) {
    const Vector2d target(18, 34);  // at the middle, mode "+-" is nearly stretched
    const auto q =
        geometry::inverse(world.rig.robot.nominal, target, mode, rig.robot(time_s).q_rad);
    ASSERT_TRUE(q);
    ASSERT_TRUE(rig.start_move(*q, 100, time_s)) << geometry::to_string(mode);
    time_s += 30.0;
    const TruePose pose = rig.true_pose(time_s);
    EXPECT_LT((pose.p_WE - target).norm(), 8.0) << geometry::to_string(mode);
    for (std::size_t i = 0; i < 6; ++i) {
      if (!pose.pushes[i] || pose.pushes[i]->displacement_mm > 50.0) continue;
      EXPECT_NEAR(rig.dial(i, time_s).value_mm, pose.pushes[i]->displacement_mm, 1e-6);
    }
  }
}

TEST(LiveRig, StopsOnTheWay) {
  const World world = world_with({});
  LiveRig rig(world);
  ASSERT_TRUE(rig.start_move(angles_at(world, {18, 64}), 10, 1.0));
  rig.stop(1.5);
  const RobotReport report = rig.robot(30.0);
  EXPECT_EQ(report.state, MotionState::kFault);
  EXPECT_EQ(report.fault, RobotFault::kStopped);
  EXPECT_LT((report.q_rad - rig.robot(1.5).q_rad).norm(), 1e-12);
}

TEST(LiveRig, AtRestADialShowsItsPlungerWithinAQuantum) {
  const World world =
      world_with({.noise_sd_mm = 0, .quantum_mm = 0.001, .hysteresis_mm = 0, .curve_mm = 0});
  LiveRig rig(world);
  ASSERT_TRUE(rig.start_move(angles_at(world, {30, 45}), 100, 0.0));
  const TruePose pose = rig.true_pose(30.0);
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(pose.pushes[i]);
    const DialFace face = rig.dial(i, 30.0);
    EXPECT_NEAR(face.value_mm, pose.pushes[i]->displacement_mm, 0.0005 + 1e-9);
    EXPECT_TRUE(face.in_contact);
    EXPECT_FALSE(face.moving_fast);
    const double quanta = face.value_mm / 0.001;
    EXPECT_NEAR(quanta, std::round(quanta), 1e-6);
  }
}

TEST(LiveRig, SettlesExponentiallyInSomeTensOfMilliseconds) {
  // A hard stop in the middle of a move leaves the plunger behind.
  const World world = world_with(kIdealDials);
  LiveRig rig(world);
  const Vector2d from = rig.robot(0.0).q_rad;
  ASSERT_TRUE(rig.start_move(from + Vector2d(0.25, 0.1), 100, 10.0));
  rig.stop(10.4);
  int seen = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const double rest = rig.true_pose(12.0).pushes[i]->displacement_mm;
    const double tau = rig.settling_s(i);
    EXPECT_GE(tau, 0.020);
    EXPECT_LE(tau, 0.050);
    // Errors at successive ticks of this dial, all after the stop.
    std::vector<double> error;
    double held = rig.dial(i, 10.4).value_mm;
    for (double t = 10.4; t < 11.6; t += 0.001) {
      const double now = rig.dial(i, t).value_mm;
      if (now != held) error.push_back(now - rest);
      held = now;
    }
    const double ratio = std::exp(-1.0 / (rig.rate_hz(i) * tau));
    ASSERT_GE(error.size(), 2U);
    if (std::abs(error[0]) < 1e-3) continue;
    EXPECT_NEAR(error[1] / error[0], ratio, 0.02);
    EXPECT_NEAR(held, rest, 1e-6);
    ++seen;
  }
  EXPECT_GE(seen, 2);
}

TEST(LiveRig, HoldsItsValueAtItsOwnRate) {
  const World world = world_with({});
  LiveRig rig(world);
  std::set<double> rates;
  for (std::size_t i = 0; i < 6; ++i) {
    int changes = 0;
    double held = rig.dial(i, 100.0).value_mm;
    for (double t = 100.0; t < 120.0; t += 0.005) {
      const double now = rig.dial(i, t).value_mm;
      if (now != held) ++changes;
      held = now;
    }
    EXPECT_GE(rig.rate_hz(i), 8.0);
    EXPECT_LE(rig.rate_hz(i), 20.0);
    // Noise of two quanta repeats a value in about one reading of eight.
    EXPECT_GT(changes, 20.0 * rig.rate_hz(i) * 0.7);
    EXPECT_LE(changes, 20.0 * rig.rate_hz(i) + 1);
    rates.insert(rig.rate_hz(i));
  }
  EXPECT_EQ(rates.size(), 6U);
}

TEST(LiveRig, NoiseAtRestHasItsStandardDeviation) {
  const World world =
      world_with({.noise_sd_mm = 0.002, .quantum_mm = 0, .hysteresis_mm = 0, .curve_mm = 0});
  LiveRig rig(world);
  const double truth = rig.true_pose(50.0).pushes[1]->displacement_mm;
  double squares = 0.0;
  constexpr int kReadings = 3000;
  for (int n = 0; n < kReadings; ++n) {
    squares += std::pow(rig.dial(1, 50.0 + n / rig.rate_hz(1)).value_mm - truth, 2);
  }
  // Standard error 1.3 % at 3000 readings; four of them.
  EXPECT_NEAR(std::sqrt(squares / kReadings), 0.002, 0.002 * 0.055);
}

TEST(LiveRig, ComingFromTheOtherSideReadsAMicrometreApart) {
  const World world =
      world_with({.noise_sd_mm = 0, .quantum_mm = 0, .hysteresis_mm = 0.001, .curve_mm = 0});
  LiveRig rig(world);
  const Vector2d q = angles_at(world, {28, 48});
  const Vector2d aside(0.05, 0.03);
  ASSERT_TRUE(rig.start_move(q - aside, 100, 0.0));
  ASSERT_TRUE(rig.start_move(q, 100, 10.0));
  std::vector<double> from_below;
  for (std::size_t i = 0; i < 6; ++i) from_below.push_back(rig.dial(i, 20.0).value_mm);
  ASSERT_TRUE(rig.start_move(q + aside, 100, 20.0));
  ASSERT_TRUE(rig.start_move(q, 100, 30.0));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(std::abs(rig.dial(i, 40.0).value_mm - from_below[i]), 0.001, 1e-6);
  }
}

TEST(LiveRig, SentToWhereItStandsItKeepsWhatTheLastMoveLeft) {
  World world =
      world_with({.noise_sd_mm = 0, .quantum_mm = 0, .hysteresis_mm = 0.001, .curve_mm = 0});
  world.effects = {
      {"joint_backlash", "joint1", {{"b_rad", 1e-3}}},
      {"passive_clearance", "elbows", {{"c_mm", 0.01}}}};
  LiveRig rig(world);
  const Vector2d q = angles_at(world, {28, 48});
  ASSERT_TRUE(rig.start_move(q - Vector2d(0.05, 0.03), 100, 0.0));
  ASSERT_TRUE(rig.start_move(q, 100, 10.0));
  std::vector<double> first;
  for (std::size_t i = 0; i < 6; ++i) first.push_back(rig.dial(i, 20.0).value_mm);
  ASSERT_TRUE(rig.start_move(q, 100, 20.0));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(rig.dial(i, 30.0).value_mm, first[i], 1e-6);
}

TEST(LiveRig, WithoutContactADialRestsAtAConstantNearZero) {
  World world = world_with({});
  world.rig.dials[4].geometry.position_mm.y() += 60.0;  // E is drawn back out of reach
  LiveRig rig(world);
  const DialFace first = rig.dial(4, 10.0);
  EXPECT_FALSE(first.in_contact);
  EXPECT_LE(std::abs(first.value_mm), 0.02);
  for (double t = 10.0; t < 20.0; t += 0.05) EXPECT_EQ(rig.dial(4, t).value_mm, first.value_mm);
}

TEST(LiveRig, PushedBeyondItsTravelADialShowsItsEnd) {
  World world = world_with({});
  world.rig.dials[1].geometry.position_mm.x() += 45.0;
  LiveRig rig(world);
  EXPECT_TRUE(rig.dial(1, 10.0).at_travel_end);
  EXPECT_NEAR(rig.dial(1, 10.0).value_mm, 50.8, 1e-9);
}

TEST(LiveRig, AFastMoveIsSeenAsSuchAndOnlyThen) {
  const World world = world_with({});
  LiveRig rig(world);
  ASSERT_TRUE(rig.start_move(rig.robot(0.0).q_rad + Vector2d(0.3, -0.3), 100, 1.0));
  bool fast = false;
  for (double t = 1.0; t < 2.0; t += 0.02) fast = fast || rig.dial(1, t).moving_fast;
  EXPECT_TRUE(fast);
  EXPECT_FALSE(rig.dial(1, 4.0).moving_fast);
}

TEST(LiveRig, TheSameSeedReadsTheSameHoweverOftenItIsAsked) {
  const World world = world_with({});
  LiveRig eager(world);
  LiveRig lazy(world);
  const Vector2d q = angles_at(world, {22, 58});
  ASSERT_TRUE(eager.start_move(q, 50, 1.0));
  ASSERT_TRUE(lazy.start_move(q, 50, 1.0));
  for (double t = 1.0; t < 9.0; t += 0.013) static_cast<void>(eager.dial(2, t));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(eager.dial(i, 9.0).value_mm, lazy.dial(i, 9.0).value_mm, 1e-9);
  }
  World other = world;
  other.seed = 2;
  LiveRig different(other);
  ASSERT_TRUE(different.start_move(q, 50, 1.0));
  EXPECT_NE(different.dial(2, 9.0).value_mm, lazy.dial(2, 9.0).value_mm);
}

TEST(LiveRig, ReadsOnAfterHoursOfRest) {
  const World world = world_with({});
  LiveRig rig(world);
  const double early = rig.dial(0, 10.0).value_mm;
  EXPECT_NEAR(rig.dial(0, 1e5).value_mm, early, 0.02);
  EXPECT_NEAR(rig.robot(1e5).temperature_c, 23.0, 1e-6);
}

}  // namespace
}  // namespace sixdial::mock_devices
