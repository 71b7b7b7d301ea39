// An arm whose tool lies on the axis of its last joint hardly shows that joint: whole
// directions of its numbers are determined by next to nothing. What is plausible holds them, so
// that a fit settles, and what the data do determine does not notice.
#include "diagnosis/plausible_robot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "geometry/robots/serial.h"
#include "geometry/tool.h"

namespace sixdial::diagnosis {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNoise_mm = 0.05;
constexpr double kRight_rad = std::numbers::pi / 2.0;

/// Six joints like those of many arms on the market, the tool on the last axis.
geometry::SerialRobot arm() {
  geometry::SerialRobot robot;
  const auto row = [&](const char* name, double a, double alpha, double d) {
    robot.rows.push_back({.name = name, .a_mm = a, .alpha_rad = alpha, .d_mm = d});
  };
  row("q1", 0.0, kRight_rad, 128.0);
  row("q2", -612.0, 0.0, 0.0);
  row("q3", -572.0, 0.0, 0.0);
  row("q4", 0.0, kRight_rad, 164.0);
  row("q5", 0.0, -kRight_rad, 116.0);
  row("q6", 0.0, 0.0, 92.0);
  robot.tool_mm = Vector3d(0.0, 0.0, 60.0);
  return robot;
}

geometry::Rig rig_of(const geometry::SerialRobot& robot) {
  geometry::Rig rig;
  rig.robot.model = geometry::serial_model(robot);
  rig.robot.nominal = rig.robot.model->nominal;
  rig.instrument.kind = "position";
  rig.instrument.dimensions = 3;
  rig.instrument.sd_mm = kNoise_mm;
  return rig;
}

/// As such arms are made: tenths of millimetres and of milliradians.
geometry::SerialRobot as_made(std::uint64_t seed) {
  geometry::SerialRobot robot = arm();
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (geometry::SerialRow& row : robot.rows) {
    row.a_mm += 0.3 * normal(engine);
    row.d_mm += 0.3 * normal(engine);
    row.alpha_rad += 5e-4 * normal(engine);
    row.theta_rad += 5e-4 * normal(engine);
  }
  return robot;
}

std::vector<simulation::Trial> measured(std::uint64_t seed, int count) {
  const geometry::Rig rig = rig_of(as_made(seed));
  const geometry::Tool tool(rig);
  std::mt19937_64 engine(seed + 1);
  std::uniform_real_distribution<double> any(-2.2, 2.2);
  std::normal_distribution<double> noise(0.0, kNoise_mm);
  std::vector<simulation::Trial> trials;
  for (int i = 0; i < count; ++i) {
    VectorXd q(6);
    for (double& each : q) each = any(engine);
    const auto at = tool.position(rig.robot.nominal, q, rig.robot.assembly);
    if (!at) continue;
    simulation::Trial& trial = trials.emplace_back();
    trial.sample = trial.point = static_cast<int>(trials.size()) - 1;
    trial.q = q;
    for (Index axis = 0; axis < 3; ++axis) trial.reading.push_back((*at)[axis] + noise(engine));
  }
  return trials;
}

TEST(PlausibleRobot, AFitSettlesWhereTheToolHardlyShowsAJoint) {
  const geometry::Rig rig = rig_of(arm());
  const simulation::ForwardModel model(rig);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Readings readings(model, measured(seed, 200));
    const JointFit fit = fit_jointly(readings, readings.nominal(), {});
    EXPECT_TRUE(fit.converged) << seed;
    const double freedom =
        static_cast<double>(readings.count()) - static_cast<double>(fit.fitted);
    // 600 readings: the standard deviation of this is 3 %.
    EXPECT_NEAR(std::sqrt(fit.residual_mm.squaredNorm() / freedom), kNoise_mm, 0.15 * kNoise_mm)
        << seed;
    const PlausibleRobot plausible = plausible_robot(readings, readings.nominal().size());
    const VectorXd moved = (fit.model - plausible.at).cwiseProduct(plausible.per_sd).cwiseAbs();
    EXPECT_LT(moved.maxCoeff(), 3.0) << seed;  // in the loose standard deviations
  }
}

TEST(PlausibleRobot, WhatIsDeterminedIsNotMoved) {
  // A link that the rig file has wrong by 40 mm, four of the loose standard deviations.
  geometry::SerialRobot wrong = arm();
  wrong.rows[1].a_mm += 40.0;
  const geometry::Rig rig = rig_of(wrong);
  const simulation::ForwardModel model(rig);
  const Readings readings(model, measured(6, 200));
  const JointFit fit = fit_jointly(readings, readings.nominal(), {});
  const auto a2 = rig.robot.model->find_parameter("a2");
  ASSERT_TRUE(a2.has_value());
  const double sd_mm = std::sqrt(fit.covariance(*a2, *a2));
  EXPECT_LT(sd_mm, 0.05);
  EXPECT_NEAR(fit.model[*a2], as_made(6).rows[1].a_mm, 4.0 * sd_mm);
}

TEST(PlausibleRobot, InThePlaneNothingIsAssumed) {
  const simulation::ForwardModel model(geometry::default_rig());
  const Readings readings(model, {});
  EXPECT_EQ(plausible_robot(readings, readings.nominal().size()).per_sd.size(), 0);
}

}  // namespace
}  // namespace sixdial::diagnosis
