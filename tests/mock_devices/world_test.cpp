// The true world: who draws it, and what each hidden effect does to the readings.
#include "mock_devices/world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "mock_devices/session_generator.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr double kClosed_mm = 1e-9;  // closed forms at 100 mm in double precision
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

World ideal_world() {
  World world;
  world.robot = drawn_robot(world.rig, 77);
  world.dials = kIdealDials;
  return world;
}

Moment at_pose(const World& world, const Vector2d& target_mm) {
  const auto q = geometry::inverse(
      world.rig.robot.nominal, target_mm, world.rig.robot.working_mode, Vector2d(1.3, 3.0));
  Moment moment;
  moment.q_rad = q.value();
  return moment;
}

TruePose pose_with(World world, const HiddenEffect& effect, const Moment& moment) {
  world.effects = {effect};
  return WorldModel(world).pose(moment).value();
}

TEST(DrawnRobot, StaysInItsRangesAndFillsThem) {
  const geometry::Rig rig = geometry::default_rig();
  const std::array<double, 10> bound{
      0.6, 0.6, 0.6, 0.6, 0.6, 1.0, 1.0, 0.3 * kRadPerDeg, kRadPerDeg, kRadPerDeg};
  std::array<double, 10> furthest{};
  double furthest_clamp = 0.0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const TrueRobot robot = drawn_robot(rig, seed);
    for (int i = 0; i < 10; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double away = std::abs(robot.parameters[i] - rig.robot.nominal[i]) / bound[k];
      ASSERT_LE(away, 1.0);
      furthest[k] = std::max(furthest[k], away);
    }
    ASSERT_LE(std::abs(robot.clamp_rad), kRadPerDeg);
    furthest_clamp = std::max(furthest_clamp, std::abs(robot.clamp_rad) / kRadPerDeg);
  }
  for (const double away : furthest) EXPECT_GT(away, 0.95);
  EXPECT_GT(furthest_clamp, 0.95);
  EXPECT_EQ(drawn_robot(rig, 5).parameters, drawn_robot(rig, 5).parameters);
}

TEST(WorldModel, WithoutEffectsEveryPlungerIsWhereGeometryPutsIt) {
  const World world = ideal_world();
  const WorldModel model(world);
  const auto reference = geometry::reference_link_angle(world.rig);
  int compared = 0;
  for (double x = 16; x <= 40; x += 4) {
    for (double y = 30; y <= 66; y += 4) {
      const Moment moment = at_pose(world, {x, y});
      const TruePose pose = model.pose(moment).value();
      const auto forward =
          geometry::forward(world.robot.parameters, moment.q_rad, world.rig.robot.assembly);
      const double gamma =
          geometry::cuboid_angle(world.rig, *reference, *forward, world.robot.clamp_rad);
      EXPECT_LT((pose.p_WE - forward->p_WE).norm(), kClosed_mm);
      for (std::size_t dial = 0; dial < 6; ++dial) {
        const auto contact = geometry::touch(
            world.rig.dials[dial].geometry, {forward->p_WE, gamma}, world.rig.cuboid.side_mm);
        if (!contact) continue;
        ASSERT_TRUE(pose.pushes[dial]);
        EXPECT_NEAR(pose.pushes[dial]->displacement_mm, contact->displacement_mm, kClosed_mm);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 300);
}

TEST(WorldModel, WarmsUpByAFewDegreesInAnHour) {
  const WorldModel model(ideal_world());
  EXPECT_NEAR(model.temperature_c(0.0), 20.0, 1e-12);
  EXPECT_NEAR(model.temperature_c(3600.0), 20.0 + 3.0 * (1 - std::exp(-3600.0 / 1500.0)), 1e-9);
  EXPECT_GT(model.temperature_c(1200.0), model.temperature_c(600.0));
}

TEST(WorldModel, ErrorCurvesAreSmoothBoundedAndEachDialsOwn) {
  World world = ideal_world();
  world.dials.curve_mm = 0.006;
  const WorldModel model(world);
  std::set<double> at_ten;
  for (std::size_t dial = 0; dial < 6; ++dial) {
    double largest = 0.0;
    double before = 0.0;
    for (int i = 0; i <= 5080; ++i) {
      const double d = 0.01 * i;
      const double error = model.shown_mm(dial, d, 0, {}) - d;
      largest = std::max(largest, std::abs(error));
      // At most 4 waves over the travel: slope below 0.006 * 4 * 2 pi / 50.8.
      if (i > 0) {
        ASSERT_LT(std::abs(error - before), 0.01 * 0.006 * 4 * 6.3 / 50.8);
      }
      before = error;
    }
    EXPECT_LE(largest, 0.006);
    EXPECT_GT(largest, 0.001);
    at_ten.insert(model.shown_mm(dial, 10.0, 0, {}));
  }
  EXPECT_EQ(at_ten.size(), 6U);
}

TEST(WorldModel, RefusesWhatMakesNoSense) {
  World world = ideal_world();
  world.effects = {{"gremlins", "joint1", {}}};
  EXPECT_THROW(WorldModel{world}, std::invalid_argument);
  world.effects = {{"joint_backlash", "joint3", {{"b_rad", 1e-4}}}};
  EXPECT_THROW(WorldModel{world}, std::invalid_argument);
  world.effects = {{"joint_backlash", "joint1", {}}};
  EXPECT_THROW(WorldModel{world}, std::invalid_argument);
  world.effects.clear();
  world.dials.curve_mm = 0.007;
  EXPECT_THROW(WorldModel{world}, std::invalid_argument);
}

TEST(HiddenEffects, BacklashFollowsTheDirectionOfApproach) {
  const World world = ideal_world();
  Moment moment = at_pose(world, {28, 48});
  moment.approach = {1, -1};
  const TruePose pose =
      pose_with(world, {"joint_backlash", "joint2", {{"b_rad", 4e-4}}}, moment);
  EXPECT_EQ(pose.theta_rad[0], moment.q_rad[0]);
  EXPECT_NEAR(pose.theta_rad[1], moment.q_rad[1] + 2e-4, 1e-15);
}

TEST(HiddenEffects, JointErrorsAreTheirSeries) {
  const World world = ideal_world();
  const Moment moment = at_pose(world, {22, 55});
  const double q = moment.q_rad[0];
  const auto turn = [&](const HiddenEffect& effect) {
    return pose_with(world, effect, moment).theta_rad[0] - q;
  };
  EXPECT_NEAR(
      turn({"joint_eccentricity", "joint1", {{"a_rad", 2e-3}, {"b_rad", -1e-3}}}),
      2e-3 * std::sin(q) - 1e-3 * std::cos(q), 1e-15);
  EXPECT_NEAR(
      turn({"joint_second_harmonic", "joint1", {{"a_rad", 2e-4}, {"b_rad", 1e-4}}}),
      2e-4 * std::sin(2 * q) + 1e-4 * std::cos(2 * q), 1e-15);
  EXPECT_NEAR(
      turn({"joint_fifth_harmonic", "joint1", {{"a_rad", 2e-4}, {"b_rad", 1e-4}}}),
      2e-4 * std::sin(5 * q) + 1e-4 * std::cos(5 * q), 1e-15);
  EXPECT_NEAR(
      turn({"joint_gain", "joint1", {{"gain", 1e-3}, {"mid_rad", 1.0}}}), 1e-3 * (q - 1.0),
      1e-15);
}

// By statics: without friction a face is pushed along its normal, which also turns the link
// that the cuboid is clamped to. The mock balances energies instead.
TEST(HiddenEffects, ComplianceTurnsTheJointsByTheForcesAndMomentsOfTheSprings) {
  const World world = ideal_world();
  const Moment moment = at_pose(world, {20, 40});
  const TruePose stiff = WorldModel(world).pose(moment).value();
  const TruePose soft = pose_with(
      world, {"joint_compliance", "joints", {{"k1_nmm_per_rad", 1e6}, {"k2_nmm_per_rad", 5e5}}},
      moment);
  Vector2d force = Vector2d::Zero();
  double moment_Nmm = 0.0;  // about the tool
  for (std::size_t i = 0; i < 6; ++i) {
    if (!stiff.pushes[i]) continue;
    const auto& dial = world.rig.dials[i].geometry;
    const double in_mm = stiff.pushes[i]->displacement_mm;
    const Vector2d normal =
        geometry::face_normal(geometry::face_towards(dial, stiff.gamma_rad), stiff.gamma_rad);
    // The plunger's guide takes what is across its axis.
    const Vector2d push = -normal * (1.0 + 0.03 * in_mm) / -dial.axis.dot(normal);
    const Vector2d ball = dial.position_mm - (dial.tip_radius_mm + in_mm) * dial.axis;
    const Vector2d arm = ball - dial.tip_radius_mm * normal - stiff.p_WE;
    force += push;
    moment_Nmm += arm.x() * push.y() - arm.y() * push.x();
  }
  const auto derivative = geometry::forward_derivative(
      world.robot.parameters, moment.q_rad, world.rig.robot.assembly);
  const Vector2d torque = derivative->J_q.transpose() * force +
                          derivative->distal_J_q.row(1).transpose() * moment_Nmm;
  ASSERT_GT(torque.norm(), 10.0);
  const Vector2d turn = soft.theta_rad - moment.q_rad;
  // The forces change by the micrometres that the joints yield: 1e-4 relative.
  EXPECT_NEAR(turn[0], torque[0] / 1e6, 1e-3 * torque.norm() / 1e6);
  EXPECT_NEAR(turn[1], torque[1] / 5e5, 1e-3 * torque.norm() / 5e5);
}

TEST(HiddenEffects, DialAndCuboidEffectsHaveTheirClosedForms) {
  const World world = ideal_world();
  const Moment moment = at_pose(world, {24, 50});
  const TruePose plain = WorldModel(world).pose(moment).value();
  const auto pushed = [&](const HiddenEffect& effect, std::size_t dial) {
    return pose_with(world, effect, moment).pushes[dial]->displacement_mm -
           plain.pushes[dial]->displacement_mm;
  };
  const double secant = 1 / std::cos(plain.gamma_rad);
  ASSERT_GT(secant, 1.00001);
  EXPECT_NEAR(pushed({"dial_mount", "C", {{"change_mm", 0.03}}}, 2), 0.03, kClosed_mm);
  EXPECT_NEAR(pushed({"dial_mount", "C", {{"change_mm", 0.03}}}, 3), 0.0, kClosed_mm);
  EXPECT_NEAR(
      pushed({"tip_radius", "dials", {{"change_mm", 0.5}}}, 4), 0.5 * (secant - 1), kClosed_mm);
  EXPECT_NEAR(
      pushed({"cuboid_size", "cuboid", {{"change_mm", 0.02}}}, 0), 0.01 * secant, kClosed_mm);
  // An offset moves opposite dials by opposite amounts.
  const HiddenEffect offset{"cuboid_offset", "cuboid", {{"x_mm", 0.1}, {"y_mm", 0.0}}};
  EXPECT_NEAR(pushed(offset, 0), 0.1 * secant, kClosed_mm);
  EXPECT_NEAR(pushed(offset, 1), -0.1 * secant, kClosed_mm);
}

TEST(HiddenEffects, ReadingEffectsChangeOnlyTheirDial) {
  World world = ideal_world();
  world.effects = {
      {"dial_gain", "B", {{"gain", 1e-3}}},
      {"dial_hysteresis", "C", {{"width_mm", 0.01}}},
      {"dial_cyclic", "D", {{"amplitude_mm", 0.005}, {"period_mm", 4.0}, {"phase_rad", 0.0}}},
      {"step", "E", {{"from_sample", 60.0}, {"amount_mm", 0.02}}}};
  const WorldModel model(world);
  Moment moment;
  EXPECT_NEAR(model.shown_mm(0, 20.0, 1, moment), 20.0, kClosed_mm);
  EXPECT_NEAR(model.shown_mm(1, 20.0, 1, moment), 20.02, kClosed_mm);
  EXPECT_NEAR(model.shown_mm(2, 20.0, -1, moment), 20.005, kClosed_mm);
  EXPECT_NEAR(model.shown_mm(3, 21.0, 1, moment), 21.005, kClosed_mm);
  moment.sample = 59;
  EXPECT_NEAR(model.shown_mm(4, 20.0, 1, moment), 20.0, kClosed_mm);
  moment.sample = 60;
  EXPECT_NEAR(model.shown_mm(4, 20.0, 1, moment), 20.02, kClosed_mm);
}

TEST(HiddenEffects, LinksGrowWithTemperatureAndTheBaseDriftsWithTime) {
  const World world = ideal_world();
  Moment moment = at_pose(world, {28, 48});
  const TruePose plain = WorldModel(world).pose(moment).value();
  const HiddenEffect growth{"link_thermal_growth", "links", {{"per_k", 2e-5}}};
  EXPECT_LT((pose_with(world, growth, moment).p_WE - plain.p_WE).norm(), kClosed_mm);
  moment.temperature_c = 25.0;
  geometry::ParameterVector longer = world.robot.parameters;
  longer.head<4>() *= 1 + 2e-5 * 5.0;
  const auto expected = geometry::forward(longer, moment.q_rad, world.rig.robot.assembly);
  EXPECT_LT((pose_with(world, growth, moment).p_WE - expected->p_WE).norm(), kClosed_mm);

  moment.time_s = 1800.0;
  const HiddenEffect drift{"base_drift", "base", {{"x_mm_per_h", 0.1}, {"y_mm_per_h", -0.04}}};
  const Vector2d moved = pose_with(world, drift, moment).p_WE - plain.p_WE;
  EXPECT_LT((moved - Vector2d(0.05, -0.02)).norm(), kClosed_mm);
}

TEST(HiddenEffects, ParseReadsTheCommandLineAndSaysWhatIsWrong) {
  const geometry::Rig rig = geometry::default_rig();
  const HiddenEffect effect = parse_effect(rig, "joint_backlash:joint2:0.0004", 1);
  EXPECT_EQ(effect, (HiddenEffect{"joint_backlash", "joint2", {{"b_rad", 0.0004}}}));
  EXPECT_EQ(parse_effect(rig, "dial_swap:C,D:1", 1).where, "C,D");
  EXPECT_EQ(parse_effect(rig, "dial_gain:E", 1).where, "E");
  EXPECT_EQ(parse_effect(rig, "dial_gain", 9).cause, "dial_gain");
  EXPECT_THROW(
      static_cast<void>(parse_effect(rig, "dial_gain:G:0.1", 1)), std::invalid_argument);
  EXPECT_THROW(
      static_cast<void>(parse_effect(rig, "dial_gain:A:much", 1)), std::invalid_argument);
  try {
    static_cast<void>(parse_effect(rig, "gremlins", 1));
    FAIL() << "an unknown cause was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("joint_backlash"), std::string::npos);
  }
}

TEST(HiddenEffects, DrawingReachesEveryCauseOfItsPool) {
  const geometry::Rig rig = geometry::default_rig();
  std::set<std::string> catalogue;
  std::set<std::string> outside;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    catalogue.insert(draw_effect(rig, seed).cause);
    outside.insert(draw_effect(rig, seed, Pool::kOutside).cause);
  }
  EXPECT_EQ(catalogue.size(), 22U);
  EXPECT_EQ(outside.size(), 7U);
  for (const std::string& cause : outside) EXPECT_FALSE(catalogue.contains(cause));
  EXPECT_EQ(draw_effect(rig, 7), draw_effect(rig, 7));
}

class EveryCause : public testing::TestWithParam<const CauseRow*> {};

TEST_P(EveryCause, ChangesWhatIsHandedOverAtEachOfItsPlaces) {
  World world;
  world.robot = drawn_robot(world.rig, 5);
  const auto plan = random_plan(world.rig, 11, 60, 30);
  const GeneratedSession plain = generate_session(world, plan);
  for (const std::string& where : GetParam()->places(world.rig)) {
    World changed = world;
    const double amplitude = GetParam()->most;
    changed.effects = {make_effect(world.rig, GetParam()->id, where, amplitude, 3, 90)};
    const GeneratedSession session = generate_session(changed, plan);
    double largest = 0.0;
    for (std::size_t i = 0; i < plan.size(); ++i) {
      for (std::size_t dial = 0; dial < 6; ++dial) {
        const auto& a = session.rows[i].dial_mm[dial];
        const auto& b = plain.rows[i].dial_mm[dial];
        if (a && b) largest = std::max(largest, std::abs(*a - *b));
      }
    }
    EXPECT_GE(largest, 0.002) << where;  // one noise: else nobody could ever find it
  }
}

TEST_P(EveryCause, DoesNothingWhenItsAmplitudeIsNothing) {
  if (GetParam()->swaps_cables) {
    EXPECT_EQ(GetParam()->least, GetParam()->most);  // there is no half swap
    return;
  }
  World world;
  world.robot = drawn_robot(world.rig, 5);
  world.dials = kIdealDials;
  const auto plan = random_plan(world.rig, 11, 20, 10);
  const GeneratedSession plain = generate_session(world, plan);
  constexpr double kNothing = 1e-15;
  for (const std::string& where : GetParam()->places(world.rig)) {
    World changed = world;
    changed.effects = {make_effect(world.rig, GetParam()->id, where, kNothing, 3, 30)};
    const GeneratedSession session = generate_session(changed, plan);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      for (std::size_t dial = 0; dial < 6; ++dial) {
        const auto& a = session.rows[i].dial_mm[dial];
        const auto& b = plain.rows[i].dial_mm[dial];
        ASSERT_EQ(a.has_value(), b.has_value());
        if (a) {
          ASSERT_NEAR(*a, *b, 1e-9) << where;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryCause, testing::ValuesIn(causes().begin(), causes().end()),
    [](const auto& each) { return std::string(each.param->id); });

}  // namespace
}  // namespace sixdial::mock_devices
