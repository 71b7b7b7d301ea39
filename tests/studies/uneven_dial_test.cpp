// A dial whose scale is uneven beyond its maker's limit, named with its curve: what the gain,
// the choice among models, the commanding model and a validation are judged on are readings
// with the curve taken away.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "geometry/tool.h"
#include "mock_devices/session_generator.h"
#include "report/documents/diagnosis_json.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "simulation/smooth_function.h"
#include "studies/diagnose.h"
#include "studies/extended_command.h"
#include "studies/measured_positions.h"

namespace sixdial::studies {
namespace {

constexpr std::uint64_t kSeed = 2;
constexpr double kRms_mm = 0.05;  // of the curve
constexpr char kDial[] = "C";

/// A drawn robot without faults, and dials without errors but for the one.
mock_devices::World uneven_world() {
  mock_devices::World world;
  world.robot = mock_devices::drawn_robot(world.rig, kSeed);
  world.seed = kSeed;
  world.dials.hysteresis_mm = 0.0;
  world.dials.curve_mm = 0.0;
  world.effects = {mock_devices::make_effect(world.rig, "dial_curve", kDial, kRms_mm, kSeed)};
  return world;
}

struct Measured {
  session::Session session;
  std::vector<Eigen::VectorXd> tool_mm;  // by sample: where it was
};

Measured measured_by(const mock_devices::World& world, std::uint64_t plan_seed) {
  const auto plan = mock_devices::random_plan(world.rig, plan_seed);
  Measured result{
      session::parse_session(
          mock_devices::session_csv(
              mock_devices::generate_session(world, plan), world.rig,
              "2026-03-02T08:30:00.000Z"),
          "session.csv", mock_devices::rig_toml(world.rig), "rig.toml"),
      {}};
  result.session.name = "uneven";
  const geometry::Tool tool(world.rig);
  for (const session::Sample& sample : result.session.samples) {
    result.tool_mm.emplace_back(
        *tool.position(world.robot.parameters, sample.q, world.rig.robot.assembly));
  }
  return result;
}

const DiagnosisResult& diagnosed() {
  static const DiagnosisResult result =
      diagnose(measured_by(uneven_world(), kSeed).session, {.bootstrap = 0, .with_gain = true});
  return result;
}

/// Of all its parts together [mm].
double curve_mm(const DiagnosisResult& result, double reading_mm) {
  const HypothesisId id{"dial_curve", kDial};
  double sum = 0.0;
  for (const FittedEffect& each : result.extended_fit.effects) {
    if (each.id == id) sum += simulation::smooth_value(each.x, reading_mm);
  }
  return sum;
}

double mean_off_mm(const PositionOfSample& positions, const Measured& truth) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!positions[i]) continue;
    sum += (*positions[i] - truth.tool_mm[i]).norm();
    ++count;
  }
  EXPECT_GT(count, 100);
  return sum / count;
}

TEST(UnevenDial, ItsCurveIsPartOfTheModelAndIsTheTrueOne) {
  // The same poses read with the curve and without, and without noise.
  mock_devices::World world = uneven_world();
  const auto plan = mock_devices::random_plan(world.rig, kSeed);
  const auto dial = static_cast<std::size_t>(
      std::ranges::find(world.rig.dials, kDial, &geometry::Dial::id) - world.rig.dials.begin());
  world.dials = mock_devices::kIdealDials;
  const auto bent = mock_devices::generate_session(world, plan);
  world.effects.clear();
  const auto straight = mock_devices::generate_session(world, plan);
  std::vector<double> truth, left, reading;
  for (std::size_t i = 0; i < bent.rows.size(); ++i) {
    const auto& with = bent.rows[i].dial_mm[dial];
    const auto& without = straight.rows[i].dial_mm[dial];
    if (!with || !without) continue;
    reading.push_back(*without);
    truth.push_back(*with - *without);
    left.push_back(truth.back() - curve_mm(diagnosed(), *without));
  }
  ASSERT_GT(truth.size(), 60U);
  // About a straight line: a shift of the dial is the robot's and the clamp's as well, a slope
  // its scale's.
  const auto spread = [&](const std::vector<double>& values) {
    const Eigen::Map<const Eigen::VectorXd> v(values.data(), std::ssize(values));
    Eigen::MatrixXd line = Eigen::MatrixXd::Ones(v.size(), 2);
    line.col(1) = Eigen::Map<const Eigen::VectorXd>(reading.data(), std::ssize(reading));
    return std::sqrt(
        (v - line * line.colPivHouseholderQr().solve(v)).squaredNorm() /
        static_cast<double>(v.size()));
  };
  EXPECT_GT(spread(truth), 0.5 * kRms_mm);
  EXPECT_LT(spread(left), 0.1 * spread(truth));
}

TEST(UnevenDial, WhatNamingItGainsIsMeasuredWithIt) {
  const DiagnosisResult& result = diagnosed();
  const GainRow* calibrated = gain_row(result, diagnosis::GainModel::kCalibrated, false);
  const GainRow* extended = gain_row(result, diagnosis::GainModel::kExtended, false);
  ASSERT_TRUE(calibrated != nullptr && extended != nullptr);
  constexpr double kNoise_mm = 0.003;  // of a shift that all dials tell, 0.002 mm each
  EXPECT_LT(extended->mean_mm, kNoise_mm);
  EXPECT_GT(calibrated->mean_mm, 3 * extended->mean_mm);
  EXPECT_LT(extended->high_mm, 0.0);  // of the difference
  EXPECT_LT(extended->rms_by_dial_mm.at(kDial), 2 * kNoise_mm);
  EXPECT_GT(calibrated->rms_by_dial_mm.at(kDial), 4 * kNoise_mm);
  // The choice among models, by G1 alone.
  ASSERT_TRUE(result.cross_validation);
  ASSERT_NE(result.cross_validation->of(CompensateBy::kExtended), nullptr);
  const auto by =
      difference(*result.cross_validation, CompensateBy::kExtended, CompensateBy::kKinematics);
  ASSERT_TRUE(by);
  EXPECT_LT(by->mean_mm, -3 * by->standard_error_mm);
}

/// Of the same rig on another day, through the stored document.
TEST(UnevenDial, AValidationMeasuresWithoutIt) {
  const mock_devices::World world = uneven_world();
  const Measured calibrated = measured_by(world, kSeed);
  const Measured again = measured_by(world, kSeed + 1);
  const DiagnosisResult stored = report::diagnosis_from_json(report::to_json(diagnosed()));
  EXPECT_TRUE(names_the_instrument(stored, calibrated.session.rig));
  const double by_file_mm = mean_off_mm(measured_positions(again.session), again);
  const double explained_mm =
      mean_off_mm(explained_positions(calibrated.session, again.session, stored), again);
  EXPECT_LT(explained_mm, 0.004);
  EXPECT_GT(by_file_mm, 3 * explained_mm);
}

TEST(UnevenDial, IsNoReasonToCommandOtherwise) {
  const geometry::Rig rig = geometry::default_rig();
  DiagnosisResult straight = diagnosed();
  std::erase_if(straight.extended_fit.effects, [](const FittedEffect& each) {
    return each.id.cause == "dial_curve";
  });
  const ExtendedCommand with(diagnosed().extended_fit, rig);
  const ExtendedCommand without(straight.extended_fit, rig);
  const Eigen::Vector2d target_mm(28, 48);
  const auto a = with.solve(target_mm, rig.robot.working_mode, {});
  const auto b = without.solve(target_mm, rig.robot.working_mode, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->q, b->q);
}

}  // namespace
}  // namespace sixdial::studies
