// The calibration ladder: truth, perfect start, perturbed start, locked parameters, fresh
// poses, spread of repeats, twice the same. And what happens when the data cannot tell.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/identifiability.h"
#include "calibration/identifier.h"
#include "calibration/pipeline.h"
#include "calibration/random.h"
#include "calibration/space_fit.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using geometry::ParameterVector;
using testing::SessionPlan;
using testing::simulate;

constexpr double kRounding_mm = 1e-10;  // 100 mm at double precision through an iterated fit

SessionPlan exact() {
  SessionPlan plan;
  plan.noise_mm = 0.0;
  return plan;
}

TEST(Ladder, TruthHasZeroResidual) {
  const auto session = simulate(exact(), 1);
  EXPECT_LT(position_rmse(session.g1, session.robot), kRounding_mm);
  EXPECT_LT(position_rmse(session.g2, session.robot), kRounding_mm);
}

TEST(Ladder, PerfectStartStays) {
  const auto session = simulate(exact(), 1);
  SpaceFitSettings settings;
  settings.start = session.robot;
  const auto fit = fit_positions(session.g1, session.nominal, settings);
  EXPECT_LT((fit.v - session.robot).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Ladder, ExactDataGiveTheRobotBack) {
  const auto session = simulate(exact(), 1);
  const auto fit = fit_positions(session.g1, session.nominal);
  EXPECT_LT((fit.v - session.robot).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Ladder, PerturbedStartRecoversWithinThreeSigma) {
  int tried = 0;
  int outside = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SessionPlan plan;
    plan.robot = testing::random_robot(plan.nominal, seed);
    const auto session = simulate(plan, seed);
    const auto fit = fit_positions(session.g1, session.nominal);
    for (int i = 0; i < geometry::kParameterCount; ++i) {
      const double sigma = std::sqrt(fit.covariance(i, i));
      ASSERT_GT(sigma, 0.0);
      outside += std::abs(fit.v[i] - session.robot[i]) > 3 * sigma ? 1 : 0;
      ++tried;
    }
  }
  EXPECT_EQ(tried, 600);
  EXPECT_LE(outside, 8);  // 0.27 % of 600 is 1.6; correlated within a session
}

TEST(Ladder, LockedParametersDoNotMove) {
  const auto session = simulate({}, 3);
  SpaceFitSettings settings;
  settings.fixed = testing::fixed({geometry::kD, geometry::kAlpha});
  const auto fit = fit_positions(session.g1, session.nominal, settings);
  EXPECT_EQ(fit.v[geometry::kD], session.nominal[geometry::kD]);
  EXPECT_EQ(fit.v[geometry::kAlpha], session.nominal[geometry::kAlpha]);
  EXPECT_EQ(fit.fit.free, 8);
  const auto estimates =
      parameter_estimates(fit.fit, session.nominal, fit.covariance, parameter_names());
  EXPECT_TRUE(estimates[geometry::kD].fixed);
  EXPECT_EQ(estimates[geometry::kD].sd, 0.0);
  EXPECT_FALSE(estimates[geometry::kL11].fixed);
}

TEST(Ladder, FreshPosesAreReachedWithinTheNoise) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto session = simulate({}, seed);
    const auto fit = fit_positions(session.g1, session.nominal);
    // noise 0.003 on each axis, and a little for the parameters' own uncertainty
    EXPECT_LT(position_rmse(session.g2, fit.v), 0.003 * std::sqrt(2.0) * 1.35);
    EXPECT_GT(position_rmse(session.g2, fit.v), 0.003 * std::sqrt(2.0) * 0.75);
  }
}

TEST(Ladder, CovarianceMatchesTheSpreadOf200Repeats) {
  constexpr int kRepeats = 200;
  Eigen::Matrix<double, geometry::kParameterCount, kRepeats> found;
  geometry::ParameterMatrix predicted = geometry::ParameterMatrix::Zero();
  double sigma = 0.0;
  SessionPlan plan;
  for (int k = 0; k < kRepeats; ++k) {
    const auto session = simulate(plan, 1000 + static_cast<std::uint64_t>(k));
    const auto fit = fit_positions(session.g1, session.nominal);
    found.col(k) = fit.v - session.robot;
    predicted += fit.covariance / kRepeats;
    sigma += fit.sigma_mm / kRepeats;
  }
  EXPECT_LT(std::abs(sigma - 0.003), 0.0001);
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const double spread = std::sqrt(found.row(i).squaredNorm() / kRepeats);
    const double ratio = spread / std::sqrt(predicted(i, i));
    EXPECT_LT(std::abs(std::log(ratio)), 0.2)
        << geometry::kParameters[static_cast<std::size_t>(i)].name << " " << ratio;
  }
}

TEST(Ladder, TwiceAndFromAnotherStartGiveTheSame) {
  const auto session = simulate({}, 5);
  const auto first = fit_positions(session.g1, session.nominal);
  const auto again = fit_positions(session.g1, session.nominal);
  EXPECT_EQ(first.v, again.v);
  SpaceFitSettings settings;
  settings.start = session.nominal + 0.5 * parameter_scale();
  const auto other = fit_positions(session.g1, session.nominal, settings);
  EXPECT_LT((first.v - other.v).cwiseQuotient(parameter_scale()).norm(), 1e-6);
}

TEST(Ladder, IntervalsHoldTheTruthInNineteenOfTwenty) {
  int inside = 0;
  int tried = 0;
  for (std::uint64_t seed = 300; seed < 360; ++seed) {
    const auto session = simulate({}, seed);
    const auto fit = fit_positions(session.g1, session.nominal);
    const auto estimates =
        parameter_estimates(fit.fit, session.nominal, fit.covariance, parameter_names());
    for (int i = 0; i < geometry::kParameterCount; ++i) {
      const auto& each = estimates[static_cast<std::size_t>(i)];
      inside += each.low_95 <= session.robot[i] && session.robot[i] <= each.high_95 ? 1 : 0;
      ++tried;
    }
  }
  const double share = static_cast<double>(inside) / tried;
  EXPECT_EQ(tried, 600);
  EXPECT_GT(share, 0.91);
  EXPECT_LT(share, 0.985);
}

TEST(Identifiability, FewPointsKeepTheArmsNearNominal) {
  for (const int points : {3, 4, 6, 9, 24}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SessionPlan plan;
      plan.g1_points = points;
      const auto session = simulate(plan, seed);
      const auto fit = fit_positions(session.g1, session.nominal);
      ASSERT_EQ(fit.fit.status, FitStatus::kConverged) << points << " points, seed " << seed;
      // the robot is within 1 mm of nominal, and a direction may be uncertain by 2 mm
      EXPECT_LT(
          (fit.v - session.nominal).cwiseQuotient(parameter_scale()).cwiseAbs().maxCoeff(), 8.0)
          << points << " points, seed " << seed;
      if (2 * points < geometry::kParameterCount) {
        EXPECT_GE(fit.fit.held, geometry::kParameterCount - 2 * points);
        const auto what = identifiability(
            fit.fit, parameter_names(), points, geometry::five_bar_model()->named_directions);
        ASSERT_FALSE(what.held.empty());
        EXPECT_FALSE(what.held.front().words.empty());
      }
    }
  }
}

constexpr const char* kCommonTurnWords =
    "alpha rises while dtheta1 and dtheta2 fall (the frame's rotation against a common shift "
    "of "
    "both motors, exact where d = 0)";

SessionPlan coaxial() {
  SessionPlan plan;
  plan.nominal << 60, 65, 58, 62, 0, 0, 0, 0, 0, 0;
  plan.robot = plan.nominal;
  plan.robot.head<4>() << 60.2, 64.9, 58.3, 61.8;
  plan.robot[geometry::kX0] = 0.4;
  plan.robot[geometry::kOffset1] = 0.005;
  plan.workspace = {-20, 20, 60, 90};
  plan.mode = {+1, -1};
  return plan;
}

TEST(Identifiability, CoaxialMotorsConfoundFrameRotationWithACommonShift) {
  const auto session = simulate(coaxial(), 4);
  SpaceFitSettings settings;
  settings.fixed =
      testing::fixed({geometry::kD});  // the motors are on one axis by construction
  const auto fit = fit_positions(session.g1, session.nominal, settings);
  EXPECT_EQ(fit.fit.status, FitStatus::kConverged);
  EXPECT_EQ(fit.fit.held, 1);
  const auto what = identifiability(
      fit.fit, parameter_names(), session.g1.size(),
      geometry::five_bar_model()->named_directions);
  ASSERT_EQ(what.held.size(), 1U);
  EXPECT_EQ(what.held.front().words, kCommonTurnWords);
  // nothing moves along it: alpha - dtheta1 - dtheta2 stays nominal
  EXPECT_LT(
      std::abs(fit.v[geometry::kAlpha] - fit.v[geometry::kOffset1] - fit.v[geometry::kOffset2]),
      1e-9);
  EXPECT_LT(position_rmse(session.g1, fit.v), 0.0055);
}

TEST(Identifiability, CoaxialMotorsAreSeenToBeWithTheirDistanceFittedToo) {
  // d free: noise puts its estimate on either side of 0, and the fit must be at the minimum on
  // both, in both spaces, with the same direction held.
  int below = 0;
  int above = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const auto session = simulate(coaxial(), seed);
    const auto space = position_space(session.g1, session.nominal);
    const auto found = identify(*find_identifier("lm"), space);
    EXPECT_EQ(found.status, FitStatus::kConverged);
    ASSERT_EQ(found.fit.held, 1) << "seed " << seed;
    const auto what = identifiability(
        found.fit, parameter_names(), session.g1.size(),
        geometry::five_bar_model()->named_directions);
    ASSERT_EQ(what.held.size(), 1U);
    EXPECT_EQ(what.held.front().words, kCommonTurnWords);
    // 200 residuals of 0.003 mm, nine parameters: at the minimum
    EXPECT_LT(found.rmse, 0.0051);
    // d is told: as well as its deviation says
    const double d_mm = found.x[geometry::kD];
    const double sd_mm = std::sqrt(found.covariance(geometry::kD, geometry::kD));
    EXPECT_LT(std::abs(d_mm), 4 * sd_mm);
    EXPECT_LT(sd_mm, 0.1);
    (d_mm < 0 ? below : above) += 1;
  }
  EXPECT_GT(below, 0);
  EXPECT_GT(above, 0);
}

TEST(Identifiability, ExactDataOfACoaxialRobotGiveItsLinksFromAnyStartOfD) {
  SessionPlan plan = coaxial();
  plan.noise_mm = 0.0;
  const auto session = simulate(plan, 4);
  for (const double start_mm : {-2.0, 0.0, 3.0}) {
    SpaceFitSettings settings;
    settings.start = session.nominal;
    (*settings.start)[geometry::kD] = start_mm;
    const auto fit = fit_positions(session.g1, session.nominal, settings);
    EXPECT_LT(fit.rmse_mm, 1e-7) << start_mm;
    EXPECT_LT((fit.v.head<5>() - session.robot.head<5>()).norm(), 1e-4) << start_mm;
    EXPECT_EQ(fit.fit.held, 1);
  }
}

TEST(Identifiability, NamesStrongCorrelationsOnly) {
  SessionPlan plan;
  plan.workspace = testing::kTable6Workspace;  // 10 mm wide: a long valley
  const auto session = simulate(plan, 6);
  const auto fit = fit_positions(session.g1, session.nominal);
  const auto what = identifiability(
      fit.fit, parameter_names(), session.g1.size(),
      geometry::five_bar_model()->named_directions);
  EXPECT_TRUE(what.held.empty());
  EXPECT_GT(what.condition, 50.0);
  EXPECT_LT(what.condition, 3000.0);
  ASSERT_FALSE(what.correlations.empty());
  for (const Correlation& each : what.correlations) {
    EXPECT_GT(std::abs(each.coefficient), kHighCorrelation);
    EXPECT_LE(std::abs(each.coefficient), 1.0);
  }
}

TEST(Identifiability, StudentQuantilesAreTheTables) {
  EXPECT_NEAR(student_95(1), 12.7062, 1e-4);
  EXPECT_NEAR(student_95(10), 2.2281, 1e-4);
  EXPECT_NEAR(student_95(190), 1.9725, 1e-4);
  EXPECT_NEAR(student_95(1'000'000), 1.95996, 1e-4);
}

TEST(PositionFit, FiveOfAHundredGrossErrorsDoNotHurtARobustFit) {
  auto session = simulate({}, 8);
  const auto clean = fit_positions(session.g1, session.nominal);
  RandomSequence random(8);
  for (int i = 0; i < session.g1.size(); i += 20) {
    session.g1.p_WE.col(i) += Eigen::Vector2d(random.uniform(0.05, 0.5), -0.2);
  }
  SpaceFitSettings settings;
  settings.loss = Loss::kCauchy;
  const auto plain = fit_positions(session.g1, session.nominal);
  EXPECT_GT(std::abs(plain.v[geometry::kX0] - clean.v[geometry::kX0]), 0.05);
  const auto robust = fit_positions(session.g1, session.nominal, settings);
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    EXPECT_LT(std::abs(robust.v[i] - clean.v[i]), 2 * std::sqrt(clean.covariance(i, i)))
        << geometry::kParameters[static_cast<std::size_t>(i)].name;
  }
}

TEST(Table2, RobotShowsThePapersErrorBeforeCalibration) {
  // Table 6, G2 before calibration: mean 2.995, std 0.179, max 3.452 mm. A grid of 1.25 mm over
  // the rectangle; the spread depends on how much of the edge a grid holds.
  const SessionPlan plan;
  const testing::Rectangle& box = testing::kTable6Workspace;
  std::vector<double> errors_mm;
  for (double x = box.x_low_mm; x <= box.x_high_mm; x += 1.25) {
    for (double y = box.y_low_mm; y <= box.y_high_mm; y += 1.25) {
      const Eigen::Vector2d target(x, y);
      const auto q = geometry::inverse(plan.nominal, target, plan.mode).value();
      const auto assembly = geometry::assembly_at(plan.nominal, q, target).value();
      errors_mm.push_back(
          (geometry::forward(plan.robot, q, assembly).value().p_WE - target).norm());
    }
  }
  const ErrorStats stats = error_stats(errors_mm);
  EXPECT_LT(std::abs(stats.mean_mm / 2.995 - 1.0), 0.02);
  EXPECT_LT(std::abs(stats.std_mm / 0.179 - 1.0), 0.03);
  EXPECT_LT(std::abs(stats.max_mm / 3.452 - 1.0), 0.03);
}

TEST(Observations, NoiseComesFromRepeats) {
  const auto session = simulate({}, 9);
  PositionObservations repeated = session.g1;
  EXPECT_FALSE(repeat_noise(position_space(repeated, session.nominal)).has_value());
  std::vector<int> twice;
  for (int i = 0; i < 100; ++i) twice.insert(twice.end(), {i, i, i});
  repeated = session.g1.subset(twice);
  RandomSequence random(10);
  for (int i = 0; i < repeated.size(); ++i) {
    repeated.p_WE.col(i) += 0.002 * Eigen::Vector2d(random.normal(), random.normal());
  }
  const auto noise = repeat_noise(position_space(repeated, session.nominal));
  ASSERT_TRUE(noise);
  EXPECT_EQ(noise->degrees_of_freedom, 400);
  EXPECT_LT(std::abs(noise->sigma_mm / 0.002 - 1.0), 0.15);
}

// Encoders do not come back to the last bit: arrivals at one pose are repeats all the same.
// What is further apart is another pose, whatever the point's number says.
TEST(Observations, NoiseComesFromRepeatsThoughEncodersJitter) {
  const auto session = simulate({}, 9);
  std::vector<int> twice;
  for (int i = 0; i < 100; ++i) twice.insert(twice.end(), {i, i});
  for (const double apart_rad : {1e-5, 1e-2}) {
    PositionObservations repeated = session.g1.subset(twice);
    RandomSequence random(10);
    for (int i = 0; i < repeated.size(); ++i) {
      repeated.p_WE.col(i) += 0.002 * Eigen::Vector2d(random.normal(), random.normal());
      if (i % 2 == 1) repeated.q_rad.col(i) += apart_rad * Eigen::Vector2d(1, -1);
    }
    const auto noise = repeat_noise(position_space(repeated, session.nominal));
    EXPECT_EQ(noise.has_value(), apart_rad < 1e-4);
    if (noise) {
      EXPECT_EQ(noise->degrees_of_freedom, 200);
    }
  }
}

TEST(Observations, LeaveOutTrialsWithoutAPosition) {
  std::vector<simulation::Trial> trials(3);
  for (simulation::Trial& trial : trials) trial.q = Eigen::Vector2d::Zero();
  trials[0].position_mm = Eigen::Vector2d(1, 2);
  trials[2].position_mm = Eigen::Vector2d(std::nan(""), 2);
  trials[0].sample = 7;
  const auto observations = position_observations(trials);
  ASSERT_EQ(observations.size(), 1);
  EXPECT_EQ(observations.sample[0], 7);
}

}  // namespace
}  // namespace sixdial::calibration
