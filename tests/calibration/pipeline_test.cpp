// The whole method on measured and simulated sessions: at the minimum, repeatable, and a
// network that helps where there is something to learn and keeps quiet where there is not.
#include "calibration/pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using testing::measured_session_00;
using testing::SessionPlan;
using testing::simulate;

// Issue 2: DQPSO's RMSE within this of the least-squares minimum of the same objective.
constexpr double kAboveMinimum_mm = 1e-5;

Result run(
    const PositionObservations& g1, const PositionObservations& g2,
    const geometry::ParameterVector& nominal, const PipelineSettings& settings = {}) {
  auto result = run_dqpso_anfis(g1, g2, nominal, settings);
  if (!result) throw std::runtime_error(result.error().message);
  return *std::move(result);
}

TEST(Pipeline, EndsAtTheLeastSquaresMinimumOnTheMeasuredSession) {
  const auto session = measured_session_00();
  const Result result = run(session.g1, session.g2, session.nominal);
  EXPECT_EQ(result.lm_status, FitStatus::kConverged);
  EXPECT_LT(std::abs(result.above_minimum_mm), kAboveMinimum_mm);
  EXPECT_LT(result.errors("ekf_dqpso").g2.mean_mm, 0.004);
  EXPECT_GT(result.errors("before").g2.mean_mm, 1.0);
  // no hidden effect there: the network must not make it worse by more than 5 %
  EXPECT_LT(
      result.errors("ekf_dqpso+anfis").g2.mean_mm,
      1.05 * result.errors("ekf_dqpso").g2.mean_mm);
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    // the simulator's contacts and its rounding leave a little beyond the noise
    EXPECT_LT(
        std::abs(result.v[i] - session.robot[i]), 4.5 * std::sqrt(result.covariance(i, i)))
        << geometry::kParameters[static_cast<std::size_t>(i)].name;
  }
}

TEST(Pipeline, EndsAtTheMinimumForRandomRobotsInEveryModeAndBothWorkspaces) {
  int tried = 0;
  double worst_mm = 0.0;
  for (const auto mode : geometry::kWorkingModes) {
    for (const bool table_6 : {false, true}) {
      const bool default_mode = mode == geometry::WorkingMode{};
      if (table_6 && !default_mode) continue;
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SessionPlan plan;
        plan.mode = mode;
        plan.workspace = table_6 ? testing::kTable6Workspace : testing::workspace_of(mode);
        plan.robot = testing::random_robot(plan.nominal, seed);
        plan.non_kinematic = seed % 2 == 0 ? 1.45 : 0.0;
        const auto session = simulate(plan, seed);
        PipelineSettings settings;
        settings.seed = seed;
        const Result result = run(session.g1, session.g2, session.nominal, settings);
        EXPECT_EQ(result.lm_status, FitStatus::kConverged);
        EXPECT_LT(std::abs(result.above_minimum_mm), kAboveMinimum_mm)
            << geometry::to_string(mode) << " seed " << seed;
        worst_mm = std::max(worst_mm, std::abs(result.above_minimum_mm));
        ++tried;
      }
    }
  }
  EXPECT_EQ(tried, 40);
  std::printf("DQPSO above the minimum, worst of %d: %.2g mm\n", tried, worst_mm);
}

struct Distribution {
  std::vector<double> ratio;  // G2 mean with the network / without
  int networks = 0;
  void print(const char* what) {
    std::ranges::sort(ratio);
    const auto at = [&](double part) {
      return ratio[static_cast<std::size_t>(part * static_cast<double>(ratio.size() - 1))];
    };
    std::printf(
        "%-32s %zu sessions, %d networks, ratio of G2 means: min %.3f, quartiles %.3f %.3f "
        "%.3f, 95%% %.3f, max %.3f\n",
        what, ratio.size(), networks, at(0), at(0.25), at(0.5), at(0.75), at(0.95), at(1));
  }
};

Distribution network_effect(double non_kinematic) {
  Distribution result;
  for (const auto mode : geometry::kWorkingModes) {
    for (std::uint64_t seed = 101; seed <= 115; ++seed) {
      SessionPlan plan;
      plan.mode = mode;
      plan.workspace = testing::workspace_of(mode);
      plan.robot = testing::random_robot(plan.nominal, seed);
      plan.non_kinematic = non_kinematic;
      const auto session = simulate(plan, seed);
      PipelineSettings settings;
      settings.qpso1.iterations = 20;  // the kinematics are not on trial here
      settings.seed = seed;
      const Result r = run(session.g1, session.g2, session.nominal, settings);
      result.ratio.push_back(
          r.errors("ekf_dqpso+anfis").g2.mean_mm / r.errors("ekf_dqpso").g2.mean_mm);
      result.networks += (r.networks[0].model.functions > 0 ? 1 : 0) +
                         (r.networks[1].model.functions > 0 ? 1 : 0);
    }
  }
  return result;
}

TEST(Network, DoesNotMakeItWorseByFivePercentWhereThereIsNothingToLearn) {
  Distribution none = network_effect(0.0);
  none.print("no non-kinematic error");
  EXPECT_EQ(none.ratio.size(), 60U);
  EXPECT_LT(none.ratio.back(), 1.05);
}

TEST(Network, ImprovesTheValidationWhereASmoothErrorIsPresent) {
  Distribution smooth = network_effect(1.45);
  smooth.print("smooth error, about 0.03 mm");
  EXPECT_EQ(smooth.ratio.size(), 60U);
  EXPECT_LT(smooth.ratio.back(), 0.95);
  EXPECT_LT(smooth.ratio[smooth.ratio.size() / 2], 0.5);
  Distribution weak = network_effect(0.3);
  weak.print("smooth error, about 0.006 mm");
  EXPECT_LT(weak.ratio[weak.ratio.size() * 95 / 100], 1.05);
  EXPECT_LT(weak.ratio[weak.ratio.size() / 2], 1.0);
}

TEST(Pipeline, IsTheSameBitForBitTwiceAndWithTwoThreads) {
  SessionPlan plan;
  plan.non_kinematic = 1.45;
  const auto session = simulate(plan, 11);
  for (const Profile profile : {Profile::kDefault, Profile::kPaper}) {
    PipelineSettings settings = settings_for(profile);
    const Result one = run(session.g1, session.g2, session.nominal, settings);
    const Result again = run(session.g1, session.g2, session.nominal, settings);
    settings.threads = 2;
    const Result two = run(session.g1, session.g2, session.nominal, settings);
    for (const Result* other : {&again, &two}) {
      EXPECT_EQ(one.v, other->v);
      EXPECT_EQ(one.qpso1_history_mm, other->qpso1_history_mm);
      EXPECT_EQ(one.qpso2_history_mm, other->qpso2_history_mm);
      EXPECT_EQ(one.networks[0].model.consequents, other->networks[0].model.consequents);
      EXPECT_EQ(one.networks[1].model.consequents, other->networks[1].model.consequents);
      for (std::size_t k = 0; k < one.table_6.size(); ++k) {
        EXPECT_EQ(one.table_6[k].g2_mm, other->table_6[k].g2_mm);
      }
    }
    settings.seed = 2;
    EXPECT_NE(
        one.qpso1_history_mm,
        run(session.g1, session.g2, session.nominal, settings).qpso1_history_mm);
  }
}

TEST(Pipeline, PaperProfileDoesWhatIsPrinted) {
  SessionPlan plan;
  plan.non_kinematic = 1.45;
  const auto session = simulate(plan, 12);
  const Result result =
      run(session.g1, session.g2, session.nominal, settings_for(Profile::kPaper));
  EXPECT_EQ(result.settings.linearisation, Linearisation::kNominal);
  EXPECT_EQ(result.settings.coordinates, SearchCoordinates::kRaw);
  EXPECT_EQ(result.qpso1_history_mm.size(), 101U);
  EXPECT_EQ(result.qpso2_history_mm.size(), 401U);
  for (const AnfisReport* anfis : {&result.networks[0], &result.networks[1]}) {
    EXPECT_EQ(anfis->model.rules(), 36);
    EXPECT_EQ(anfis->model.consequents.size(), 108);
    // 108 consequents on 80 samples reach the target at once, and the paper stops there.
    EXPECT_EQ(anfis->target_reached, 1);
    EXPECT_TRUE(anfis->stopped_at_target());
    EXPECT_EQ(anfis->train_rmse_mm.size(), 1U);
    EXPECT_EQ(anfis->check_rmse_mm.size(), 1U);
    EXPECT_FALSE(anfis->selection);
    EXPECT_LT(anfis->model.effective_parameters, 80.0);
  }
  // each stage is no worse than the one before on what it fits
  EXPECT_LE(result.stage("ekf_qpso1").rmse_g1_mm, result.stage("ekf").rmse_g1_mm);
  EXPECT_LE(result.stage("ekf_dqpso").rmse_g1_mm, result.stage("ekf_qpso1").rmse_g1_mm);
  EXPECT_LE(result.stage("lm").rmse_g1_mm, result.stage("ekf_dqpso").rmse_g1_mm + 1e-12);
  EXPECT_LT(
      result.errors("ekf_dqpso+anfis").g2.mean_mm, result.errors("before").g2.mean_mm / 50);
}

TEST(Pipeline, ReportsWhatTable6Needs) {
  const auto session = simulate({}, 13);
  const Result result = run(session.g1, session.g2, session.nominal);
  const std::vector<std::string> expected{"before",    "ekf", "ekf_qpso1",
                                          "ekf_dqpso", "lm",  "ekf_dqpso+anfis"};
  ASSERT_EQ(result.table_6.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const MethodErrors& row = result.table_6[k];
    EXPECT_EQ(row.method, expected[k]);
    EXPECT_EQ(row.g1.count, 100);
    EXPECT_EQ(row.g2.count, 50);
    ASSERT_EQ(row.g2_mm.size(), 50U);
    EXPECT_EQ(row.g2.max_mm, *std::ranges::max_element(row.g2_mm));
    EXPECT_GT(row.g1.std_mm, 0.0);
    // mean^2 + std^2 (n-1)/n = rmse^2
    EXPECT_NEAR(
        row.g1.mean_mm * row.g1.mean_mm + row.g1.std_mm * row.g1.std_mm * 0.99,
        row.g1.rmse_mm * row.g1.rmse_mm, 1e-12);
  }
  EXPECT_TRUE(result.before_uses_targets);
  EXPECT_EQ(result.filter_history.size(), 100U);
  EXPECT_EQ(result.qpso2_history.size(), 401U);
  EXPECT_EQ(geometry::ParameterVector(result.nominal + result.qpso2_history.back()), result.v);
  ASSERT_EQ(result.parameters.size(), 10U);
  for (const ParameterEstimate& each : result.parameters) {
    EXPECT_GT(each.sd, 0.0);
    EXPECT_LT(each.low_95, each.value);
    EXPECT_GT(each.high_95, each.value);
  }
  EXPECT_EQ(result.degrees_of_freedom, 190);
  EXPECT_LT(std::abs(result.sigma_mm / 0.003 - 1.0), 0.2);
  for (const StageResult& stage : result.stages) EXPECT_GT(stage.seconds, 0.0);
  EXPECT_GE(result.total_seconds, result.anfis_seconds);
  EXPECT_THROW((void)result.stage("unknown"), std::out_of_range);
}

TEST(Pipeline, WithoutTargetsTheErrorBeforeIsAgainstNominal) {
  auto session = simulate({}, 14);
  const Result with = run(session.g1, session.g2, session.nominal);
  for (auto& target : session.g2.target_mm) target.reset();
  const Result without = run(session.g1, session.g2, session.nominal);
  EXPECT_FALSE(without.before_uses_targets);
  // targets were commanded by nominal inverse kinematics, so both are the same error
  EXPECT_NEAR(with.errors("before").g2.mean_mm, without.errors("before").g2.mean_mm, 1e-9);
}

TEST(Pipeline, WorksWithoutValidationPoints) {
  const auto session = simulate({}, 15);
  const Result result = run(session.g1, {}, session.nominal);
  EXPECT_EQ(result.errors("ekf_dqpso").g2.count, 0);
  EXPECT_LT(std::abs(result.above_minimum_mm), kAboveMinimum_mm);
}

TEST(Pipeline, LockedParametersDoNotMove) {
  const auto session = simulate({}, 16);
  PipelineSettings settings;
  settings.fixed = testing::fixed({geometry::kD, geometry::kY0});
  for (const auto coordinates : {SearchCoordinates::kWhitened, SearchCoordinates::kRaw}) {
    settings.coordinates = coordinates;
    const Result result = run(session.g1, session.g2, session.nominal, settings);
    for (const StageResult& stage : result.stages) {
      EXPECT_EQ(stage.v[geometry::kD], 90.0) << stage.name;
      EXPECT_EQ(stage.v[geometry::kY0], 0.0) << stage.name;
    }
    if (coordinates == SearchCoordinates::kWhitened) {
      EXPECT_LT(std::abs(result.above_minimum_mm), kAboveMinimum_mm);
    }
  }
}

TEST(Pipeline, FewPointsHoldWhatTheyCannotTell) {
  for (const int points : {3, 6, 9}) {
    SessionPlan plan;
    plan.g1_points = points;
    const auto session = simulate(plan, 17);
    const Result result = run(session.g1, session.g2, session.nominal);
    EXPECT_LT(
        (result.v - session.nominal).cwiseQuotient(parameter_scale()).cwiseAbs().maxCoeff(),
        10.0)
        << points;
    if (2 * points < geometry::kParameterCount) {
      EXPECT_FALSE(result.identifiability.held.empty());
    }
    for (const MethodErrors& row : result.table_6) EXPECT_TRUE(std::isfinite(row.g2.mean_mm));
  }
}

TEST(Pipeline, SaysWhyItRefuses) {
  auto session = simulate({}, 18);
  const std::vector<int> two{0, 1};
  auto few = run_dqpso_anfis(session.g1.subset(two), session.g2, session.nominal);
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().kind, Trouble::Kind::kTooFewSamples);
  session.g1.q_rad.col(41) = Eigen::Vector2d(3.1, 0.0);  // elbows 210 mm apart
  auto unreachable = run_dqpso_anfis(session.g1, session.g2, session.nominal);
  ASSERT_FALSE(unreachable);
  EXPECT_EQ(unreachable.error().kind, Trouble::Kind::kUnreachable);
  EXPECT_NE(unreachable.error().message.find("point 41"), std::string::npos);
}

TEST(Pipeline, TellsItsProgressAndCanBeCancelledInEveryStage) {
  const auto session = simulate({}, 19);
  double last = 0.0;
  int calls = 0;
  const auto result = run_dqpso_anfis(
      session.g1, session.g2, session.nominal, {}, [&](const PipelineProgress& progress) {
        EXPECT_GE(progress.fraction, last);
        EXPECT_LE(progress.fraction, 1.0);
        last = progress.fraction;
        ++calls;
      });
  ASSERT_TRUE(result);
  EXPECT_EQ(last, 1.0);
  EXPECT_GT(calls, 500);
  for (const PipelineStage stage :
       {PipelineStage::kNoiseSearch, PipelineStage::kParameterSearch,
        PipelineStage::kResidual}) {
    std::stop_source stop;
    const auto cancelled = run_dqpso_anfis(
        session.g1, session.g2, session.nominal, settings_for(Profile::kPaper),
        [&](const PipelineProgress& progress) {
          if (progress.stage == stage) stop.request_stop();
        },
        stop.get_token());
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().kind, Trouble::Kind::kCancelled);
  }
}

TEST(Pipeline, ProfilesAreKnownByName) {
  for (const Profile profile : {Profile::kDefault, Profile::kPaper}) {
    EXPECT_EQ(profile_from(to_string(profile)), profile);
  }
  EXPECT_FALSE(profile_from("papers"));
}

}  // namespace
}  // namespace sixdial::calibration
