// Which model is recommended: by cross-validation within G1, the simplest of those that are as
// good, never one that a validation ruled out; and that one is what commands, what the report
// says and what its table holds.
#include "studies/recommendation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "report/documents/recommendation_json.h"
#include "report/report_run.h"
#include "report/verdict.h"
#include "report/words/recommendation_words.h"
#include "studies/calibrate.h"
#include "studies/diagnose.h"
#include "tests/support/paths.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Errors around `mean_mm` that differ from sample to sample, the same way for all models.
CheckedModel checked(CompensateBy by, double mean_mm, double own_scatter_mm = 0.0) {
  CheckedModel model{.by = by};
  for (int i = 0; i < 100; ++i) {
    const double common = 0.2 * std::sin(1.7 * i);
    const double own = own_scatter_mm * std::sin(0.9 * i + 3.0 * static_cast<double>(by));
    model.error_mm.push_back(mean_mm * (1.0 + common) + own);
  }
  return model;
}

CalibrationResult calibration_with(double kinematics_mm, double full_mm) {
  CalibrationResult result;
  result.inputs = {.session = "demo", .data_hash = "sha256:1"};
  result.result_method = "lm+gp";
  result.residual_model = StoredResidualModel{.name = "gp"};
  result.parameters = {{.name = "l11", .unit = "mm", .nominal = 60.0, .identified = 59.8}};
  result.methods = {
      {.id = "before", .g1 = SetErrors{.mean_mm = 2.8}, .g2 = SetErrors{.mean_mm = 2.9}},
      {.id = "lm", .g2 = SetErrors{.mean_mm = 0.017}},
      {.id = "lm+gp", .g2 = SetErrors{.mean_mm = 0.016}}};
  result.cross_validation = CrossValidation{
      .folds = 5,
      .residual_model = "gp",
      .models = {
          checked(CompensateBy::kKinematics, kinematics_mm),
          checked(CompensateBy::kFull, full_mm)}};
  return result;
}

DiagnosisResult diagnosis_with(double kinematics_mm, double extended_mm, double full_mm) {
  DiagnosisResult result;
  result.inputs = {.session = "demo", .data_hash = "sha256:1"};
  result.parameters = {{"l11", "mm", 60.0, 59.8, 0.01, 59.69, 0.05}};
  result.extended_fit.effects = {{.id = {"joint_backlash", "joint2"}, .x = {6e-4}}};
  result.extended_fit.residual_model = StoredResidualModel{.name = "anfis"};
  result.gain = {
      {.model = diagnosis::GainModel::kExtended, .mean_mm = 0.0118},
      {.model = diagnosis::GainModel::kExtended, .network = true, .mean_mm = 0.003}};
  result.cross_validation = CrossValidation{
      .folds = 5,
      .residual_model = "anfis",
      .models = {
          checked(CompensateBy::kKinematics, kinematics_mm),
          checked(CompensateBy::kFull, kinematics_mm),
          checked(CompensateBy::kExtended, extended_mm),
          checked(CompensateBy::kExtendedFull, full_mm)}};
  return result;
}

ValidationResult validation_with(const std::vector<std::pair<CompensateBy, double>>& reached) {
  ValidationResult result;
  result.inputs.calibration_data_hash = "sha256:1";
  for (const auto& [by, mean_mm] : reached) {
    result.methods.push_back(
        {.by = by, .errors = ReachedErrors{.mean_mm = mean_mm, .points = 50}});
  }
  return result;
}

TEST(Recommendation, TheBetterModelIsTakenWhereItIsBetterByMoreThanChance) {
  const Recommendation better = recommend(calibration_with(0.02, 0.005));
  EXPECT_EQ(better.by, CompensateBy::kFull);
  EXPECT_EQ(better.because, ChosenBecause::kBest);
  EXPECT_EQ(better.residual_model, "gp");
  EXPECT_NEAR(better.of(CompensateBy::kFull)->held_out_mm.value(), 0.005, 5e-4);
  EXPECT_EQ(better.of(CompensateBy::kFull)->g2_mm, 0.016);

  CalibrationResult close = calibration_with(0.02, 0.02);
  close.cross_validation->models[1] = checked(CompensateBy::kFull, 0.0199, 0.01);
  const Recommendation simplest = recommend(close);
  EXPECT_EQ(simplest.by, CompensateBy::kKinematics);
  EXPECT_FALSE(simplest.residual_model.has_value());
}

TEST(Recommendation, ATwentiethOfTheErrorIsNotWorthAnotherModel) {
  // Better at every sample, beyond any chance, by 3 %.
  const Recommendation recommended = recommend(calibration_with(0.0200, 0.0194));
  EXPECT_EQ(recommended.by, CompensateBy::kKinematics);
  EXPECT_EQ(recommended.because, ChosenBecause::kSimplest);
  EXPECT_EQ(recommended.best, CompensateBy::kFull);
}

TEST(Recommendation, G2OnlyReports) {
  CalibrationResult calibration = calibration_with(0.02, 0.005);
  calibration.methods[2].g2->mean_mm = 1.0;  // whatever G2 says of the residual model
  EXPECT_EQ(recommend(calibration).by, CompensateBy::kFull);
}

TEST(Recommendation, CausesBringTheirOwnParameters) {
  const CalibrationResult calibration = calibration_with(0.02, 0.018);
  const DiagnosisResult diagnosis = diagnosis_with(0.02, 0.012, 0.003);
  const Recommendation recommended = recommend(calibration, &diagnosis);
  EXPECT_EQ(recommended.by, CompensateBy::kExtendedFull);
  EXPECT_TRUE(recommended.by_diagnosis);
  EXPECT_EQ(recommended.parameters.front().identified, 59.69);
  EXPECT_LT(recommended.parameters.front().low_95, 59.60);
  ASSERT_EQ(recommended.causes.size(), 1U);
  EXPECT_EQ(recommended.causes.front().name(), "joint_backlash@joint2");
  EXPECT_EQ(recommended.residual_model, "anfis");
  EXPECT_THAT(report::recommended_name(recommended), HasSubstr("backlash of joint 2"));
  EXPECT_THAT(report::why_recommended(recommended), HasSubstr("No simpler model"));

  DiagnosisResult other = diagnosis;
  other.inputs.data_hash = "sha256:2";
  EXPECT_FALSE(is_extended(recommend(calibration, &other).by));
}

TEST(Recommendation, WhatMissesByMoreThanPlainKinematicsIsNeverRecommended) {
  const CalibrationResult calibration = calibration_with(0.02, 0.018);
  const DiagnosisResult diagnosis = diagnosis_with(0.02, 0.012, 0.003);
  const ValidationResult validation = validation_with(
      {{CompensateBy::kBefore, 2.9},
       {CompensateBy::kKinematics, 0.017},
       {CompensateBy::kExtended, 0.012},
       {CompensateBy::kExtendedFull, 0.0299}});
  const Recommendation recommended = recommend(calibration, &diagnosis, &validation);
  EXPECT_EQ(recommended.by, CompensateBy::kExtended);
  EXPECT_EQ(recommended.because, ChosenBecause::kRuledOut);
  EXPECT_TRUE(recommended.of(CompensateBy::kExtendedFull)->ruled_out);
  EXPECT_FALSE(recommended.of(CompensateBy::kExtended)->ruled_out);
  EXPECT_THAT(report::why_recommended(recommended), HasSubstr("Commanded again"));
  EXPECT_FALSE(recommended.residual_model.has_value());
}

TEST(Recommendation, WhereNothingHelpsNothingIsRecommended) {
  const ValidationResult validation =
      validation_with({{CompensateBy::kBefore, 0.02}, {CompensateBy::kKinematics, 0.03}});
  EXPECT_EQ(
      recommend(calibration_with(0.02, 0.02), nullptr, &validation).by, CompensateBy::kBefore);
  const Recommendation worse = recommend(calibration_with(4.0, 5.0));
  EXPECT_EQ(worse.by, CompensateBy::kBefore);
  EXPECT_THAT(report::how_to_use(worse, "demo").front(), Not(HasSubstr("Enter")));
}

TEST(Recommendation, WithoutACrossValidationItIsPlainKinematics) {
  CalibrationResult early = calibration_with(0.02, 0.005);
  early.cross_validation.reset();
  const Recommendation recommended = recommend(early);
  EXPECT_EQ(recommended.by, CompensateBy::kKinematics);
  EXPECT_EQ(recommended.because, ChosenBecause::kNotCompared);
  EXPECT_THAT(report::why_recommended(recommended), HasSubstr("not compared"));
}

TEST(Recommendation, AReportAfterAValidationBeginsWithWhatWasReached) {
  const session::Session session =
      session::read_bundle(std::filesystem::path(test_paths::test_data()) / "session_00");
  const CalibrationResult calibration = calibrate(session, {.method = "lm"});
  const auto words = [&](const ValidationResult* validation) {
    return report::verdict(
        report::report_data(calibration, session, "", {.validation = validation}));
  };
  const report::Verdict modelled = words(nullptr);
  EXPECT_THAT(modelled.to_do, ::testing::Contains(HasSubstr("Confirm on the robot")));
  ValidationResult validation =
      validation_with({{CompensateBy::kBefore, 2.71}, {CompensateBy::kKinematics, 0.0123}});
  validation.inputs.calibration_data_hash = calibration.inputs.data_hash;
  validation.inputs.validation_session = "again";
  const report::Verdict measured = words(&validation);
  EXPECT_THAT(measured.to_do, Not(::testing::Contains(HasSubstr("Confirm on the robot"))));
  EXPECT_DOUBLE_EQ(measured.before_mm, 2.71);
  EXPECT_DOUBLE_EQ(measured.after_mm, 0.0123);
  EXPECT_THAT(measured.basis, HasSubstr("session again"));
}

/// A backlash and a smooth error of 0.02 mm: what kinematics alone takes over.
mock_devices::World bent_world(std::uint64_t seed) {
  mock_devices::World world = testing::simple_world(seed);
  world.warp.amplitude_mm = 0.02;
  world.effects = {mock_devices::parse_effect(world.rig, "joint_backlash:joint2:0.0006", seed)};
  return world;
}

session::Session measured_in(const mock_devices::World& world, std::uint64_t plan_seed) {
  session::PlanOptions options;
  options.seed = plan_seed;
  session::Plan plan = session::plan_random(world.rig, 100, options).value();
  options.set = "G2";
  options.seed = plan_seed + 1;
  const session::Plan g2 = session::plan_random(world.rig, 50, options).value();
  plan.points.insert(plan.points.end(), g2.points.begin(), g2.points.end());
  return testing::measured(world, plan);
}

/// Recommended 95 % intervals that hold the truth, and how many there are.
std::pair<int, int> intervals_that_hold(const mock_devices::World& world, std::uint64_t seed) {
  const session::Session session = measured_in(world, seed);
  const CalibrationResult calibration = calibrate(session, {.method = "lm"});
  const DiagnosisResult diagnosis = diagnose(session, {.bootstrap = 0});
  const Recommendation recommended = recommend(calibration, &diagnosis);
  EXPECT_TRUE(is_extended(recommended.by)) << seed;
  int inside = 0;
  for (std::size_t i = 0; i < recommended.parameters.size(); ++i) {
    const ParameterRow& row = recommended.parameters[i];
    const double truth = world.robot.parameters[static_cast<Eigen::Index>(i)];
    inside += row.low_95 <= truth && truth <= row.high_95 ? 1 : 0;
  }
  return {inside, static_cast<int>(recommended.parameters.size())};
}

// 95 % of thirty, less two standard deviations of that count; parameters are correlated.
constexpr int kHold = 25;

TEST(Recommendation, ItsIntervalsHoldTheTruthWhereABacklashAndASmoothErrorAreInTheData) {
  int inside = 0;
  for (const std::uint64_t seed : {2021U, 5U, 77U}) {
    const auto [hold, all] = intervals_that_hold(bent_world(seed), seed);
    EXPECT_EQ(all, 10);
    inside += hold;
  }
  EXPECT_GE(inside, kHold);
}

TEST(Recommendation, ItsIntervalsHoldTheTruthWhereDialsHaveErrorCurves) {
  int inside = 0;
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    mock_devices::World world = testing::simple_world(seed);
    world.dials.curve_mm = 0.002;
    world.dials.hysteresis_mm = 0.001;
    world.effects = {
        mock_devices::parse_effect(world.rig, "joint_backlash:joint1:0.0008", seed)};
    inside += intervals_that_hold(world, seed).first;
  }
  EXPECT_GE(inside, kHold);
}

}  // namespace
}  // namespace sixdial::studies
