// Which noise the numbers rest on, and how sure the predicted position is.
#include "calibration/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "calibration/random.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using geometry::ParameterVector;
using testing::SessionPlan;
using testing::simulate_dials;

SessionPlan plan(int points, double noise_mm = 0.002) {
  SessionPlan result;
  result.g1_points = points;
  result.noise_mm = noise_mm;
  return result;
}

ObservationSpace positions(const testing::DialSession& session) {
  return position_space(position_observations(session.g1), session.rig.robot.nominal);
}

Identified fit(const ObservationSpace& space) {
  return identify(*find_identifier("lm"), space);
}

/// Every point three times, with noise of its own.
testing::DialSession repeated(double between_mm, double within_mm) {
  testing::DialSession session = simulate_dials(plan(30, between_mm), 3);
  std::vector<simulation::Trial> trials;
  RandomSequence random(4);
  for (const simulation::Trial& trial : session.g1) {
    for (int repeat = 0; repeat < 3; ++repeat) {
      simulation::Trial again = trial;
      again.repeat = repeat;
      for (auto& value : again.reading) {
        if (value) *value += within_mm * random.normal();
      }
      const Eigen::Vector2d noise(random.normal(), random.normal());
      again.position_mm = Eigen::Vector2d(trial.position_mm.value() + within_mm * noise);
      trials.push_back(again);
    }
  }
  session.g1 = trials;
  return session;
}

TEST(Noise, ComesFromRepeatsWhereThereAreAny) {
  const auto session = repeated(0.0, 0.004);
  for (const bool dials : {false, true}) {
    const auto space = dials ? dial_space(session.g1, session.rig) : positions(session);
    const auto noise = noise_estimate(space, fit(space).fit);
    EXPECT_EQ(noise.source, NoiseSource::kRepeats);
    EXPECT_EQ(noise.degrees_of_freedom, dials ? 2 * space.rows() / 3 : 120);
    EXPECT_LT(std::abs(noise.sigma_mm / 0.004 - 1.0), 0.2);
    EXPECT_FALSE(noise.lack_of_fit) << noise.words;
    EXPECT_NE(noise.words.find("repeated"), std::string::npos);
  }
}

TEST(Noise, SaysWhenTheFitLeavesMoreThanRepeatsShow) {
  const auto session = repeated(0.02, 0.002);  // what points have of their own is no noise
  const auto space = positions(session);
  const auto noise = noise_estimate(space, fit(space).fit);
  EXPECT_EQ(noise.source, NoiseSource::kRepeats);
  EXPECT_LT(std::abs(noise.sigma_mm / 0.002 - 1.0), 0.2);
  ASSERT_TRUE(noise.lack_of_fit);
  EXPECT_GT(*noise.lack_of_fit, 4.0);
  EXPECT_NE(noise.words.find("not in the model"), std::string::npos);
}

TEST(Noise, ComesFromTheResidualElse) {
  const auto session = simulate_dials(plan(100), 5);
  const auto space = dial_space(session.g1, session.rig);
  const auto noise = noise_estimate(space, fit(space).fit);
  EXPECT_EQ(noise.source, NoiseSource::kResidual);
  EXPECT_LT(std::abs(noise.sigma_mm / 0.002 - 1.0), 0.1);
  EXPECT_NE(noise.words.find("leaves over"), std::string::npos);
}

TEST(Noise, ComesFromTheRigFileWhereTheFitHasNoFreedom) {
  const auto session = simulate_dials(plan(6), 6);
  const auto space = positions(session);
  const auto noise = noise_estimate(space, fit(space).fit);
  EXPECT_EQ(noise.source, NoiseSource::kRigFile);
  EXPECT_EQ(noise.degrees_of_freedom, 0);
  EXPECT_EQ(noise.sigma_mm, space.mean_sigma());
  EXPECT_GT(noise.sigma_mm, 0.0005);
  EXPECT_NE(noise.words.find("rig file"), std::string::npos);
  EXPECT_LT(std::abs(quantile_95(noise) - 1.96), 0.001);
}

TEST(Noise, OfAFreeCuboidLeavesItsRotationsOutOfTheFreedom) {
  const auto session = simulate_dials(plan(100), 7, geometry::Mount::kFree);
  const auto space = dial_space(session.g1, session.rig);
  const auto noise = noise_estimate(space, fit(space).fit);
  EXPECT_LT(std::abs(noise.sigma_mm / 0.002 - 1.0), 0.1);
}

TEST(PositionUncertainty, IsTheSpreadOfPredictionsOverTheWorkspace) {
  constexpr int kRepeats = 150;
  constexpr int kColumns = 3;
  constexpr int kRows = 3;
  const Workspace box{Eigen::Vector2d(16, 30), Eigen::Vector2d(40, 66)};
  Eigen::Matrix<double, 2 * kColumns * kRows, kRepeats> missed;
  PositionUncertainty map;
  double inside = 0;
  for (int k = 0; k < kRepeats; ++k) {
    const auto session = simulate_dials(plan(40), static_cast<std::uint64_t>(700 + k));
    const auto space = positions(session);
    const auto found = fit(space);
    const auto noise = noise_estimate(space, found.fit);
    Eigen::MatrixXd covariance;
    static_cast<void>(
        estimates_with_noise(space, found.fit, weighting_of(space, {}), noise, {}, covariance));
    const ParameterVector v = found.x;
    map = position_uncertainty(
        geometry::Tool(session.rig), v, covariance, found.fit, session.rig.robot.working_mode,
        box, quantile_95(noise), 0.0, kColumns, kRows);
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const int i = row * kColumns + column;
        const auto k_i = static_cast<std::size_t>(i);
        const Eigen::Vector2d p(
            map.x_mm[static_cast<std::size_t>(column)],
            map.y_mm[static_cast<std::size_t>(row)]);
        const auto q = geometry::inverse(v, p, session.rig.robot.working_mode).value();
        const auto assembly = geometry::assembly_at(v, q, p).value();
        const Eigen::Vector2d error =
            geometry::forward(session.robot, q, assembly).value().p_WE - p;
        missed.block<2, 1>(2 * i, k) = error;
        inside += error.norm() <= map.radius_95_mm[k_i] ? 1 : 0;
      }
    }
  }
  for (int i = 0; i < kColumns * kRows; ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const double spread = std::sqrt(missed.row(2 * i + axis).squaredNorm() / kRepeats);
      const double predicted = map.sd_mm[static_cast<std::size_t>(i)][axis];
      // Spread of a spread, 6 %, and poses that differ from session to session.
      EXPECT_LT(std::abs(std::log(spread / predicted)), 0.5) << i << " " << axis;
    }
  }
  const double share = inside / (kRepeats * kColumns * kRows);
  EXPECT_GT(share, 0.93);  // a circle around an ellipse holds a little more than 95 %
  EXPECT_LE(share, 1.0);
  EXPECT_GE(map.max_sd_mm, map.mean_sd_mm);
}

TEST(PositionUncertainty, AHeldDirectionThatMovesNothingIsKnownToMoveNothing) {
  SessionPlan coaxial;
  coaxial.nominal << 60, 65, 58, 62, 0, 0, 0, 0, 0, 0;
  coaxial.robot = coaxial.nominal;
  coaxial.robot.head<4>() << 60.2, 64.9, 58.3, 61.8;
  coaxial.workspace = {-20, 20, 60, 90};
  coaxial.mode = {+1, -1};
  const auto session = testing::simulate(coaxial, 4);
  const auto space = position_space(session.g1, session.nominal);
  IdentifySettings settings;
  settings.fixed = fixed_by_name(space, std::vector<std::string>{"d"}).value();
  const auto found = identify(*find_identifier("lm"), space, settings);
  ASSERT_EQ(found.fit.held, 1);
  const auto map = position_uncertainty(
      geometry::Tool(geometry::five_bar_model(), 2), found.x, found.covariance, found.fit,
      coaxial.mode, {Eigen::Vector2d(-20, 60), Eigen::Vector2d(20, 90)}, 1.96);
  ASSERT_EQ(map.held_effect_mm.size(), 1U);
  EXPECT_LT(map.held_effect_mm[0], 1e-9);
  EXPECT_GT(map.max_sd_mm, 0.0005);
  EXPECT_LT(map.max_sd_mm, 0.01);
}

TEST(PositionUncertainty, SaysWhereTheRobotCannotGo) {
  const auto session = simulate_dials(plan(100), 8);
  const auto space = positions(session);
  const auto found = fit(space);
  const auto map = position_uncertainty(
      geometry::Tool(session.rig), found.x, found.covariance, found.fit,
      session.rig.robot.working_mode, {Eigen::Vector2d(16, 30), Eigen::Vector2d(400, 66)}, 1.96,
      0.0, 5, 2);
  EXPECT_TRUE(std::isfinite(map.sd(0, 0)));
  EXPECT_FALSE(std::isfinite(map.sd(4, 0)));
  EXPECT_TRUE(std::isfinite(map.max_sd_mm));
}

// The study of issue 3, point 2: errors really made, not deviations that a fit claims. With 40
// sessions the geometric mean of ten ratios is uncertain by some 10 %.
TEST(Precision, RawReadingsMakeLessThanHalfTheErrorOfPositions) {
  constexpr int kSessions = 40;
  constexpr double kLeastGain = 2.0;  // required; 2.4 .. 3 seen
  Eigen::ArrayXd by_positions = Eigen::ArrayXd::Zero(geometry::kParameterCount);
  Eigen::ArrayXd by_dials = by_positions;
  int held = 0;
  for (std::uint64_t seed = 200; seed < 200 + kSessions; ++seed) {
    SessionPlan random = plan(100);
    random.robot = testing::random_robot(random.nominal, seed);
    const auto session = simulate_dials(random, seed);
    const auto from_positions = fit(positions(session));
    const auto from_dials = fit(dial_space(session.g1, session.rig));
    held += from_positions.fit.held + from_dials.fit.held;
    by_positions +=
        (from_positions.x.head(geometry::kParameterCount) - random.robot).array().square();
    by_dials += (from_dials.x.head(geometry::kParameterCount) - random.robot).array().square();
  }
  EXPECT_EQ(held, 0);
  const Eigen::ArrayXd gain = (by_positions / by_dials).sqrt();
  const double mean = std::exp(gain.log().mean());
  std::printf(
      "raw readings against positions, error of each parameter over %d sessions:", kSessions);
  for (const double each : gain) std::printf(" %.2f", each);
  std::printf(", geometric mean %.2f\n", mean);
  EXPECT_GT(mean, kLeastGain);
  EXPECT_GT(gain.minCoeff(), 1.0);
}

TEST(Precision, RawReadingsAreTwiceAsPreciseOverManySessions) {
  double log_ratio = 0.0;
  int count = 0;
  for (std::uint64_t seed = 50; seed < 60; ++seed) {
    SessionPlan random = plan(100);
    random.robot = testing::random_robot(random.nominal, seed);
    const auto session = simulate_dials(random, seed);
    const auto by_positions = fit(positions(session));
    const auto by_dials = fit(dial_space(session.g1, session.rig));
    for (int i = 0; i < geometry::kParameterCount; ++i) {
      log_ratio += 0.5 * std::log(by_positions.covariance(i, i) / by_dials.covariance(i, i));
      ++count;
    }
  }
  EXPECT_EQ(count, 100);
  EXPECT_GT(std::exp(log_ratio / count), 2.0);
}

}  // namespace
}  // namespace sixdial::calibration
