// One law suite for all identifiers, in both observation spaces.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "calibration/identifiability.h"
#include "calibration/identifier.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using testing::SessionPlan;
using testing::simulate;
using testing::simulate_dials;

IdentifySettings quick() {
  IdentifySettings settings;
  settings.qpso1 = {20, 15};
  settings.qpso2 = {40, 250};
  return settings;
}

class EveryIdentifier : public ::testing::TestWithParam<const Identifier*> {
 protected:
  [[nodiscard]] bool one_pass() const {
    // one step, or one pass with forgetting: near the minimum, not at it
    const auto name = GetParam()->name;
    return name == "lse" || name == "ekf" || name == "ekf_qpso1";
  }
};

TEST_P(EveryIdentifier, StaysAtNominalIfNominalIsTheTruth) {
  SessionPlan plan;
  plan.robot = plan.nominal;
  plan.noise_mm = 0.0;
  const auto session = simulate(plan, 1);
  const auto found =
      identify(*GetParam(), position_space(session.g1, session.nominal), quick());
  EXPECT_LT((found.x - session.nominal).norm(), 1e-9);
  EXPECT_LT(found.rmse, 1e-9);
}

TEST_P(EveryIdentifier, FindsTheRobotWithinThreeSigmaOnFreshPoses) {
  const auto session = simulate({}, 2);
  const auto space = position_space(session.g1, session.nominal);
  const auto found = identify(*GetParam(), space, quick());
  EXPECT_EQ(found.status, FitStatus::kConverged);
  const auto fresh = position_space(session.g2, session.nominal);
  if (one_pass()) {
    EXPECT_LT(fresh.rmse(found.x), 0.12);  // from 2.8 mm before
    return;
  }
  EXPECT_LT(fresh.rmse(found.x), 0.003 * std::sqrt(2.0) * 1.35);
  for (int i = 0; i < space.parameters(); ++i) {
    EXPECT_LT(std::abs(found.x[i] - session.robot[i]), 3.5 * std::sqrt(found.covariance(i, i)))
        << space.parameter_info[static_cast<std::size_t>(i)].name;
  }
}

TEST_P(EveryIdentifier, DoesNotMoveLockedParameters) {
  const auto session = simulate({}, 3);
  const auto space = position_space(session.g1, session.nominal);
  IdentifySettings settings = quick();
  const std::vector<std::string> names{"d", "alpha"};
  settings.fixed = fixed_by_name(space, names).value();
  const auto found = identify(*GetParam(), space, settings);
  EXPECT_EQ(found.x[geometry::kD], 90.0);
  EXPECT_EQ(found.x[geometry::kAlpha], 0.0);
  EXPECT_EQ(found.fit.free, 8);
  EXPECT_LT(found.rmse, 0.5);
}

TEST_P(EveryIdentifier, TwiceAndWithTwoThreadsGiveTheSame) {
  const auto session = simulate({}, 4);
  const auto space = position_space(session.g1, session.nominal);
  IdentifySettings settings = quick();
  const auto one = identify(*GetParam(), space, settings);
  const auto again = identify(*GetParam(), space, settings);
  settings.threads = 2;
  const auto two = identify(*GetParam(), space, settings);
  EXPECT_EQ(one.x, again.x);
  EXPECT_EQ(one.x, two.x);
}

TEST_P(EveryIdentifier, WorksOnRawDialReadings) {
  SessionPlan plan;
  plan.noise_mm = 0.002;
  plan.g1_points = 60;
  const auto session = simulate_dials(plan, 5);
  const auto space = dial_space(session.g1, session.rig);
  ASSERT_EQ(space.parameters(), 11);
  ASSERT_GT(space.rows(), 4 * space.samples());
  IdentifySettings settings = quick();
  settings.qpso1 = {10, 6};
  const auto found = identify(*GetParam(), space, settings);
  const auto fresh =
      position_space(position_observations(session.g2), session.rig.robot.nominal);
  const double before = fresh.rmse(session.rig.robot.nominal);
  EXPECT_GT(before, 2.0);
  EXPECT_LT(fresh.rmse(found.x.head<10>()), one_pass() ? 0.15 : 0.006);
  if (!one_pass()) {
    EXPECT_LT(std::abs(found.x[10] - session.clamp_rad), 0.001);
  }
}

TEST_P(EveryIdentifier, FewPointsDoNotThrowTheArmsAway) {
  SessionPlan plan;
  plan.g1_points = 4;
  const auto session = simulate(plan, 6);
  const auto space = position_space(session.g1, session.nominal);
  const auto found = identify(*GetParam(), space, quick());
  EXPECT_LT(
      (found.x - session.nominal).cwiseQuotient(space.scale()).cwiseAbs().maxCoeff(), 12.0);
  EXPECT_GE(found.fit.held, 2);
}

INSTANTIATE_TEST_SUITE_P(
    , EveryIdentifier, ::testing::ValuesIn(all_identifiers()),
    [](const auto& each) { return std::string{each.param->name}; });

TEST(Identifiers, AreFoundByTheirNamesWhichAreUnique) {
  for (const Identifier* each : all_identifiers()) {
    EXPECT_EQ(find_identifier(each->name), each);
    EXPECT_FALSE(each->description.empty());
  }
  EXPECT_EQ(find_identifier("nonsense"), nullptr);
}

TEST(Identifiers, AnUnknownParameterIsNamed) {
  const auto session = simulate({}, 7);
  const std::vector<std::string> names{"d", "l33"};
  const auto fixed = fixed_by_name(position_space(session.g1, session.nominal), names);
  ASSERT_FALSE(fixed);
  EXPECT_EQ(fixed.error(), "l33");
}

TEST(Identifiers, TheReferenceAndTheSearchAgree) {
  const auto session = simulate({}, 8);
  const auto space = position_space(session.g1, session.nominal);
  const double minimum = identify(*find_identifier("lm"), space).rmse;
  for (const char* name : {"lse_iterated", "ekf_dqpso"}) {
    EXPECT_LT(std::abs(identify(*find_identifier(name), space).rmse - minimum), 1e-8) << name;
  }
}

TEST(DialSpace, DerivativesAreThoseOfDifferences) {
  for (const auto mount :
       {geometry::Mount::kDistal1, geometry::Mount::kDistal2, geometry::Mount::kFree}) {
    const auto session = simulate_dials({}, 9, mount);
    const auto space = dial_space(session.g1, session.rig);
    ASSERT_GT(space.samples(), 90);
    const bool free = mount == geometry::Mount::kFree;
    Eigen::VectorXd x = space.nominal;
    // The eliminated rotation's own turn is left out (Kaufman's approximation): right where the
    // residual is small, so near the truth.
    if (free) x = session.robot;
    for (int sample = 0; sample < space.samples(); sample += 10) {
      const int rows = space.rows(sample);
      Eigen::VectorXd e(rows);
      Eigen::VectorXd high(rows);
      Eigen::VectorXd low(rows);
      Eigen::MatrixXd J(rows, space.parameters());
      ASSERT_TRUE(space.evaluate(sample, x, e, &J));
      for (int i = 0; i < space.parameters(); ++i) {
        const double h = 1e-5 * space.scale()[i];
        Eigen::VectorXd moved = x;
        moved[i] += h;
        ASSERT_TRUE(space.evaluate(sample, moved, high, nullptr));
        moved[i] -= 2 * h;
        ASSERT_TRUE(space.evaluate(sample, moved, low, nullptr));
        const Eigen::VectorXd difference = -(high - low) / (2 * h);
        const double tolerance = free ? 1e-3 : 1e-5;
        EXPECT_LT((difference - J.col(i)).norm(), tolerance * (1.0 + J.col(i).norm()));
      }
    }
  }
}

TEST(DialSpace, IsAtLeastTwiceAsPreciseAsPositions) {
  SessionPlan plan;
  plan.noise_mm = 0.002;
  const auto session = simulate_dials(plan, 10);
  IdentifySettings settings;
  const auto by_dials =
      identify(*find_identifier("lm"), dial_space(session.g1, session.rig), settings);
  const auto by_positions = identify(
      *find_identifier("lm"),
      position_space(position_observations(session.g1), session.rig.robot.nominal), settings);
  double log_ratio = 0.0;
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    log_ratio += 0.05 * std::log(by_positions.covariance(i, i) / by_dials.covariance(i, i));
    EXPECT_LT(
        std::abs(by_dials.x[i] - session.robot[i]), 4 * std::sqrt(by_dials.covariance(i, i)));
  }
  std::printf(
      "dials are %.2f times as precise as positions (geometric mean)\n", std::exp(log_ratio));
  EXPECT_GT(std::exp(log_ratio), 2.0);
}

TEST(DialSpace, AFreeMountIsFittedWithItsRotationsEliminated) {
  SessionPlan plan;
  plan.noise_mm = 0.002;
  const auto session = simulate_dials(plan, 11, geometry::Mount::kFree);
  const auto space = dial_space(session.g1, session.rig);
  EXPECT_EQ(space.parameters(), 10);
  const auto found = identify(*find_identifier("lm"), space);
  EXPECT_EQ(found.status, FitStatus::kConverged);
  for (int i = 0; i < 10; ++i) {
    EXPECT_LT(std::abs(found.x[i] - session.robot[i]), 4.5 * std::sqrt(found.covariance(i, i)))
        << space.parameter_info[static_cast<std::size_t>(i)].name;
  }
}

}  // namespace
}  // namespace sixdial::calibration
