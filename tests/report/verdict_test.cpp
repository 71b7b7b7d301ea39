// The words on the first half page follow from the figures.
#include "report/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sample_session.h"

namespace sixdial::report {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

ErrorStatistics errors(double mean_mm, int points) {
  return {
      .mean_mm = mean_mm, .std_mm = 0.3 * mean_mm, .max_mm = 2.0 * mean_mm, .points = points};
}

/// The paper's Table 6: before, EKF-DQPSO, EKF-DQPSO & ANFIS.
ReportData paper_table_6() {
  ReportData out;
  out.methods = {
      {.id = "before", .name = "Before", .g1 = errors(3.051, 100), .g2 = errors(2.995, 50)},
      {.id = "ekf_dqpso",
       .name = "EKF-DQPSO",
       .g1 = errors(0.034, 100),
       .g2 = errors(0.038, 50)},
      {.id = "ekf_dqpso+anfis",
       .name = "EKF-DQPSO & ANFIS",
       .g1 = errors(0.018, 100),
       .g2 = errors(0.022, 50),
       .has_residual_model = true}};
  return out;
}

TEST(Verdict, ThePapersRobotIsCalibrated) {
  const Verdict v = verdict(paper_table_6());
  EXPECT_EQ(v.state, CalibrationState::kCalibrated);
  EXPECT_DOUBLE_EQ(v.before_mm, 2.995);
  EXPECT_DOUBLE_EQ(v.after_mm, 0.022);
  EXPECT_THAT(v.headline, HasSubstr("136 times less"));  // 2.995 / 0.022
  EXPECT_THAT(v.basis, HasSubstr("50 validation points (G2)"));
  EXPECT_THAT(v.to_do, Contains(HasSubstr("residual model")));
  EXPECT_THAT(v.not_judged, IsEmpty());
}

TEST(Verdict, WithoutG2ItIsNotValidated) {
  ReportData data = paper_table_6();
  for (ShownMethod& m : data.methods) m.g2.reset();
  const Verdict v = verdict(data);
  EXPECT_EQ(v.state, CalibrationState::kNotValidated);
  EXPECT_DOUBLE_EQ(v.after_mm, 0.018);
  EXPECT_THAT(v.not_judged, Contains(HasSubstr("no validation points")));
}

TEST(Verdict, ACalibrationThatDoesNotHelpIsNotToBeUsed) {
  ReportData data = paper_table_6();
  data.methods[2].g2 = errors(2.995, 50);
  const Verdict v = verdict(data);
  EXPECT_EQ(v.state, CalibrationState::kNotImproved);
  EXPECT_THAT(v.to_do, Contains(HasSubstr("Do not use")));
}

TEST(Verdict, AnErrorFarAboveTheNoiseIsNoCalibratedRobot) {
  // Two dials exchanged: 3.9 mm become 1.5 mm, which is a gain, and nonsense.
  ReportData data = paper_table_6();
  data.methods[0].g2 = errors(3.9, 50);
  data.methods[2].g2 = errors(1.5, 50);
  data.position_noise_mm = 0.003;
  const Verdict v = verdict(data);
  EXPECT_EQ(v.state, CalibrationState::kNotImproved);
  EXPECT_THAT(v.title, HasSubstr("something is wrong"));
  EXPECT_THAT(v.headline, HasSubstr("500 times what the dials can tell"));
  EXPECT_THAT(v.to_do, Contains(HasSubstr("no two dials are exchanged")));
  EXPECT_THAT(v.to_do, Not(Contains(HasSubstr("Enter the identified"))));
  data.methods[2].g2 = errors(0.022, 50);  // the paper's: 7 times the noise
  EXPECT_EQ(verdict(data).state, CalibrationState::kCalibrated);
}

TEST(Verdict, ANetworkThatBringsNothingIsNoProofThatNothingIsLeft) {
  ReportData data = paper_table_6();
  data.methods[2].g2 = errors(0.038, 50);  // as without it
  data.position_noise_mm = 0.003;
  EXPECT_THAT(
      verdict(data).cautions, Contains(HasSubstr("does not depend on the joint angles alone")));
  data.position_noise_mm = 0.03;
  EXPECT_THAT(verdict(data).cautions, Contains(HasSubstr("already explain all but the noise")));
}

TEST(Verdict, WhatADiagnosisSaysJoinsItsLists) {
  ReportData data = paper_table_6();
  data.to_do = {"Backlash of joint 2: take up the play."};
  data.not_judged = {"Eccentricity of joint 1: not seen on these poses."};
  const Verdict v = verdict(data);
  EXPECT_THAT(v.to_do, Contains(data.to_do[0]));
  EXPECT_THAT(v.not_judged, Contains(data.not_judged[0]));
}

TEST(Verdict, ASmallGainIsCalledSmall) {
  ReportData data = paper_table_6();
  data.methods[2].g2 = errors(2.0, 50);
  EXPECT_EQ(verdict(data).state, CalibrationState::kImproved);
}

TEST(Verdict, AResidualModelThatHarmsIsAdvisedAgainst) {
  ReportData data = paper_table_6();
  data.methods[2].g2 = errors(0.045, 50);
  const Verdict v = verdict(data);
  EXPECT_THAT(v.cautions, Contains(HasSubstr("Use the parameters alone")));
  EXPECT_THAT(v.cautions, Contains(HasSubstr("too closely")));  // G1 0.018, G2 0.045
  EXPECT_THAT(v.to_do, Not(Contains(HasSubstr("residual model"))));
}

TEST(Verdict, AResidualModelWithoutEffectIsSaidToBringNothing) {
  ReportData data = paper_table_6();
  data.methods[2].g2 = errors(0.0375, 50);
  EXPECT_THAT(verdict(data).cautions, Contains(HasSubstr("makes no difference")));
}

TEST(Verdict, WhatIsLeftIsComparedWithTheNoise) {
  ReportData data = paper_table_6();
  data.position_noise_mm = 0.02;
  EXPECT_THAT(verdict(data).cautions, Contains(HasSubstr("as small as the noise")));
  data.position_noise_mm = 0.004;
  EXPECT_THAT(verdict(data).cautions, Contains(HasSubstr("5.5 times the noise")));
}

TEST(Verdict, ASwarmShortOfTheMinimumIsReported) {
  ReportData data = paper_table_6();
  data.least_squares_rmse_mm = 0.0232;
  data.rmse_mm = 0.0232 + 2e-3;
  EXPECT_THAT(verdict(data).cautions, Contains(HasSubstr("least-squares minimum")));
  data.rmse_mm = 0.0232 + 1e-6;
  EXPECT_THAT(verdict(data).cautions, Not(Contains(HasSubstr("least-squares minimum"))));
}

TEST(Verdict, WhatThePosesCannotTellIsNamed) {
  ReportData data = paper_table_6();
  data.unidentifiable = {"alpha and dtheta1 + dtheta2"};
  data.condition_number = 5000.0;
  const Verdict v = verdict(data);
  EXPECT_THAT(v.not_judged, Contains(HasSubstr("alpha and dtheta1 + dtheta2")));
  EXPECT_THAT(v.not_judged, Contains(HasSubstr("condition number 5000")));
}

TEST(Verdict, WhatWasMeasuredAgainOwnsTheHeadline) {
  ReportData data = paper_table_6();
  data.first_to_do = {"Use this model."};
  data.headline = Headline{
      .model = "robot and backlash of joint 2",
      .before = errors(2.99, 50),
      .after = errors(0.0125, 49),
      .predicted_mm = 0.0118,
      .measured_in = "demo.validation"};
  data.measured_again = true;
  const Verdict v = verdict(data);
  EXPECT_DOUBLE_EQ(v.before_mm, 2.99);
  EXPECT_DOUBLE_EQ(v.after_mm, 0.0125);
  EXPECT_THAT(v.headline, HasSubstr("measured again"));
  EXPECT_THAT(v.basis, HasSubstr("49 targets"));
  EXPECT_THAT(v.basis, HasSubstr("demo.validation"));
  EXPECT_THAT(v.basis, HasSubstr("predicted were 11.8"));
  EXPECT_THAT(v.basis, HasSubstr("reached are 12.5"));
  EXPECT_THAT(v.to_do, Contains("Use this model."));
  EXPECT_THAT(v.to_do, Not(Contains(HasSubstr("Confirm"))));
}

TEST(Verdict, ASessionWithoutResultSaysSo) {
  const Verdict v = verdict(ReportData{});
  EXPECT_EQ(v.state, CalibrationState::kUnknown);
  EXPECT_THAT(v.headline, HasSubstr("no calibration result"));
  ReportData unknown_method = paper_table_6();
  unknown_method.result_method = "no such method";
  EXPECT_EQ(verdict(unknown_method).state, CalibrationState::kUnknown);
}

/// 50 validation points; the worst lies `largest_mm` off, known to `expanded_mm`.
studies::Conformity judged(studies::Decision decision, int accepted, int rejected) {
  return {
      .tolerance_mm = 0.05,
      .set = "G2",
      .points = 50,
      .accepted = accepted,
      .rejected = rejected,
      .largest_mm = 0.044,
      .expanded_mm = 0.008,
      .decision = decision};
}

TEST(Verdict, WithoutAToleranceNoColourSaysThatItIsGoodEnough) {
  ReportData data = paper_table_6();
  data.position_noise_mm = 0.02;
  const Verdict v = verdict(data);
  EXPECT_EQ(v.mood, Mood::kPlain);
  EXPECT_THAT(v.title, HasSubstr("no tolerance stated"));
  EXPECT_THAT(v.decision, HasSubstr("tolerance_mm"));
}

TEST(Verdict, GreenNeedsAToleranceThatIsKeptAndNothingLeftOpen) {
  ReportData data = paper_table_6();
  data.position_noise_mm = 0.02;
  data.conformity = judged(studies::Decision::kAccepted, 50, 0);
  EXPECT_EQ(verdict(data).mood, Mood::kGood);
  EXPECT_THAT(verdict(data).title, HasSubstr("within tolerance"));
  EXPECT_THAT(verdict(data).decision, HasSubstr("0.0440 mm with U = 0.0080 mm (k = 2)"));
  data.cause_remains = true;  // a diagnosis named one
  EXPECT_EQ(verdict(data).mood, Mood::kOpen);
  data.cause_remains = false;
  data.position_noise_mm = 0.003;  // what remains is far above the noise: structure
  EXPECT_EQ(verdict(data).mood, Mood::kOpen);
}

TEST(Verdict, BetweenTheGuardBandsItCannotBeDecided) {
  ReportData data = paper_table_6();
  data.position_noise_mm = 0.02;
  data.conformity = judged(studies::Decision::kUndecided, 48, 0);
  const Verdict v = verdict(data);
  EXPECT_EQ(v.mood, Mood::kOpen);
  EXPECT_THAT(v.decision, HasSubstr("cannot be decided"));
  EXPECT_THAT(v.decision, HasSubstr("2 of 50 points"));
}

TEST(Verdict, RedIsOutsideTolerance) {
  ReportData data = paper_table_6();
  data.position_noise_mm = 0.02;
  data.conformity = judged(studies::Decision::kRejected, 30, 5);
  const Verdict v = verdict(data);
  EXPECT_EQ(v.mood, Mood::kBad);
  EXPECT_THAT(v.title, HasSubstr("outside tolerance"));
  EXPECT_THAT(v.decision, HasSubstr("5 of 50 points"));
}

TEST(Verdict, WithoutValidationPointsNothingIsGreen) {
  ReportData data = paper_table_6();
  for (ShownMethod& m : data.methods) m.g2.reset();
  data.position_noise_mm = 0.02;
  data.conformity = judged(studies::Decision::kUndecided, 50, 0);
  data.conformity->validated = false;
  const Verdict v = verdict(data);
  EXPECT_EQ(v.mood, Mood::kOpen);
  EXPECT_THAT(v.decision, HasSubstr("Measure validation points"));
}

TEST(Verdict, LostSamplesAndRowsAreCounted) {
  const Verdict v = verdict(sample_session());
  EXPECT_EQ(v.state, CalibrationState::kCalibrated);
  EXPECT_THAT(v.not_judged, Contains(HasSubstr("1 of 150 samples gave no position")));
  EXPECT_THAT(v.not_judged, Contains(HasSubstr("1 row was left out")));
}

}  // namespace
}  // namespace sixdial::report
