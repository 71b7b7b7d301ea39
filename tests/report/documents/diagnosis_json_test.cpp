// A diagnosis is written and read back whole; what earlier versions wrote is read as well, and
// a document that cannot be a diagnosis is refused by the name of its key.
#include "report/documents/diagnosis_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"
#include "studies/error.h"
#include "tests/support/paths.h"

namespace sixdial::report {
namespace {

using ::testing::HasSubstr;

Json document_of(const std::string& number) {
  return Json::parse(
      std::ifstream(test_paths::test_data() + "/documents/diagnosis_" + number + ".json"));
}

struct EarlierDiagnosis : ::testing::TestWithParam<const char*> {};

// Words too: whoever changes a sentence on purpose makes these documents again.
TEST_P(EarlierDiagnosis, IsWrittenAgainAsItWas) {
  const Json before = document_of(GetParam());
  const Json after = to_json(diagnosis_from_json(before));
  for (const auto& [key, value] : before.items()) EXPECT_EQ(after[key], value) << key;
  EXPECT_EQ(after.size(), before.size());
}
INSTANTIATE_TEST_SUITE_P(, EarlierDiagnosis, ::testing::Values("09", "13"));

TEST(DiagnosisDocument, IsReadAsStatesNotAsWords) {
  const studies::DiagnosisResult unknown = diagnosis_from_json(document_of("09"));
  EXPECT_EQ(verdict_kind(unknown), studies::VerdictKind::kUnknown);
  ASSERT_EQ(unknown.causes.size(), 1U);
  EXPECT_EQ(unknown.causes[0].id.name(), "joint_compliance@joints");
  EXPECT_EQ(unknown.causes[0].standing, studies::Standing::kConfirmed);
  EXPECT_EQ(unknown.causes[0].signature->along.axis, studies::CurveAxis::kForce);
  ASSERT_EQ(unknown.not_testable.size(), 1U);
  EXPECT_EQ(unknown.not_testable[0].why, diagnosis::WhyNotTestable::kAbsorbed);
  EXPECT_NE(limit_of(unknown, unknown.not_testable[0].id), nullptr);
  EXPECT_TRUE(unknown.left_along[0].has_smooth);
  EXPECT_EQ(unknown.parameters.size(), 11U);

  const studies::DiagnosisResult doubtful = diagnosis_from_json(document_of("13"));
  ASSERT_EQ(doubtful.causes.size(), 2U);
  EXPECT_TRUE(doubtful.causes[0].is_doubtful());
  EXPECT_FALSE(doubtful.causes[0].is_only_suspected());
  EXPECT_EQ(doubtful.causes[1].kind, studies::CauseKind::kOutliers);
  EXPECT_EQ(doubtful.gross_readings.size(), 4U);
  const DiagnosisVerdict verdict = verdict_in_words(doubtful);
  EXPECT_EQ(verdict.found[0].cause, 0U);
}

TEST(DiagnosisDocument, KeepsADialsCurveAndSaysHowWideItIs) {
  studies::DiagnosisResult result = diagnosis_from_json(document_of("09"));
  result.causes = {
      {.id = {"dial_curve", "C"},
       .estimate = {
           {"half_span", "mm", 0.031, 0.001},
           {"rms", "mm", 0.017, 0.0},
           {"limit", "mm", 0.006, 0.0}}}};
  const studies::DiagnosisResult again = diagnosis_from_json(to_json(result));
  ASSERT_EQ(again.causes.size(), 1U);
  EXPECT_TRUE(again.causes[0].is_in_fit());
  EXPECT_THAT(verdict_in_words(again).title, HasSubstr("Uneven scale of dial C"));
  const std::string size = size_in_words(again.causes[0]);
  EXPECT_THAT(size, HasSubstr("up to 0.0310 mm ± 0.0020 mm either way"));  // k = 2
  EXPECT_THAT(size, HasSubstr("accuracy_mm allows 0.0060 mm"));
}

TEST(DiagnosisDocument, KeepsTheRigAsTheDataSeeItAndSaysSo) {
  studies::DiagnosisResult result = diagnosis_from_json(document_of("09"));
  EXPECT_FALSE(result.rig.has_value());
  result.rig = {
      {"place of dial C across its axis", "mm", 0.14, 0.01, 0.1, true},
      {"side of the cuboid", "mm", 0.001, 0.002, 0.01, true}};
  result.causes.push_back(
      {.kind = studies::CauseKind::kRigGeometry,
       .id = {"rig_geometry", "rig"},
       .estimate = {{"place of dial C across its axis", "mm", 0.14, 0.01}}});
  const studies::DiagnosisResult again = diagnosis_from_json(to_json(result));
  ASSERT_TRUE(again.rig.has_value());
  ASSERT_EQ(again.rig->size(), 2U);
  EXPECT_DOUBLE_EQ(again.rig->front().ratio(), 1.4);
  EXPECT_EQ(again.causes.back().kind, studies::CauseKind::kRigGeometry);
  EXPECT_FALSE(again.causes.back().is_data_fault());
  const DiagnosisVerdict verdict = verdict_in_words(again);
  EXPECT_THAT(verdict.title, HasSubstr("the rig's own geometry"));
  EXPECT_THAT(
      verdict.trust,
      ::testing::Contains(HasSubstr("stands within what its file states; off by most: place "
                                    "of dial C across its axis")));
}

TEST(DiagnosisDocument, ACauseOfAFitThatDidNotSettleIsTiedWithThatInJsonAndInWords) {
  Json document = document_of("09");
  document["causes"][0]["tied_with"] =
      Json::array({{{"cause", "unsettled_fit"}, {"where", ""}, {"log_odds", 0.0}}});
  document["causes"][0]["certainty"] = "tied";
  const studies::DiagnosisResult result = diagnosis_from_json(document);
  ASSERT_EQ(result.causes[0].tied_with.size(), 1U);
  EXPECT_EQ(result.causes[0].tied_with[0].kind, studies::RivalKind::kUnsettled);
  EXPECT_EQ(result.causes[0].certainty(), studies::Certainty::kTied);
  const Json again = to_json(result);
  EXPECT_EQ(again["causes"][0]["tied_with"][0]["cause"], "unsettled_fit");
  EXPECT_EQ(again["causes"][0]["certainty"], "tied");
  const DiagnosisVerdict verdict = verdict_in_words(result);
  ASSERT_FALSE(verdict.found.empty());
  EXPECT_THAT(verdict.found[0].text, HasSubstr("the fit had not settled yet"));
  EXPECT_THAT(verdict.found[0].text, ::testing::Not(HasSubstr("odds")));
}

// Documents of version 0.1 have no code for it: their words stand for it, as they were then.
TEST(DiagnosisDocument, WhyNotTestableIsACodeAndOfOldDocumentsTheOldWords) {
  Json document = document_of("09");
  Json& each = document["not_testable"][0];
  EXPECT_EQ(each["why"], "absorbed");
  each["needs"] = "any words";
  EXPECT_EQ(
      diagnosis_from_json(document).not_testable[0].why, diagnosis::WhyNotTestable::kAbsorbed);
  each.erase("why");
  for (const auto& [words, why] :
       {std::pair{"dial columns", diagnosis::WhyNotTestable::kNoDials},
        {"time_utc", diagnosis::WhyNotTestable::kNoTime},
        {"points approached from both sides", diagnosis::WhyNotTestable::kOneApproach},
        {"other poses: more working modes, a wider range of joint angles",
         diagnosis::WhyNotTestable::kAbsorbed}}) {
    each["needs"] = words;
    EXPECT_EQ(diagnosis_from_json(document).not_testable[0].why, why) << words;
  }
  each["needs"] = "good luck";
  EXPECT_THROW((void)diagnosis_from_json(document), studies::StudyError);
}

struct Spoilt {
  const char* pointer;
  Json value;
  const char* said;
};

TEST(DiagnosisDocument, WhatItCannotBeIsRefusedByTheNameOfTheKey) {
  const Json whole = document_of("13");
  const Spoilt cases[] = {
      {"/schema", "sixdial.calibration", "sixdial.diagnosis"},
      {"/schema_version", 7, "version"},
      {"/causes/0/standing", "certain", "causes[0].standing"},
      {"/causes/0/estimate", 3, "causes[0].estimate"},
      {"/causes/0/signature_plot/covariate", "the moon", "covariate"},
      {"/gain/1/name", "best", "gain[1].name"},
      {"/noise/source", "guessed", "noise.source"},
      {"/by_covariate/0/label/0", "few", "label"},
      {"/extended_model/model", "long", "extended_model.model"}};
  for (const Spoilt& each : cases) {
    Json document = whole;
    document[Json::json_pointer(each.pointer)] = each.value;
    try {
      (void)diagnosis_from_json(document);
      ADD_FAILURE() << each.pointer << " was read";
    } catch (const studies::StudyError& error) {
      EXPECT_EQ(error.code(), studies::StudyErrorCode::kBadData);
      EXPECT_THAT(error.what(), HasSubstr(each.said)) << each.pointer;
      EXPECT_FALSE(error.hint().empty());
    }
  }
  Json less = whole;
  less.erase("residuals");
  EXPECT_THROW((void)diagnosis_from_json(less), studies::StudyError);
}

TEST(DiagnosisDocument, EveryAxisGroupAndClassIsFoundAgainByItsName) {
  using studies::CurveAxis;
  int axes = 0;
  for (int i = 0; i <= static_cast<int>(CurveAxis::kDial); ++i) {
    const auto axis = static_cast<CurveAxis>(i);
    const bool of_joint = axis == CurveAxis::kJointAngle || axis == CurveAxis::kJointSlide ||
                          axis == CurveAxis::kOtherJoint;
    const studies::Along along{axis, of_joint ? 3 : -1};
    EXPECT_EQ(axis_from(axis_name(along)), along) << axis_name(along);
    ++axes;
  }
  EXPECT_EQ(axes, 20);
  EXPECT_EQ(axis_from("theta0"), std::nullopt);
  for (int i = 0; i <= static_cast<int>(studies::CurveGroupOf::kPlungerOut); ++i) {
    const auto group = static_cast<studies::CurveGroupOf>(i);
    EXPECT_EQ(group_from(group_name(group)), group);
  }
  studies::LeftInClass arrival;
  ASSERT_TRUE(class_from(CurveAxis::kJointArrival, "joint 1 up, joint 2 unknown", arrival));
  EXPECT_EQ(arrival.signs, (std::vector<int>{1, 0}));
  EXPECT_FALSE(class_from(CurveAxis::kJointArrival, "joint 2 up", arrival));
  studies::LeftInClass range;
  ASSERT_TRUE(class_from(CurveAxis::kToolX, "-1.5e-05 to 2", range));
  EXPECT_EQ(range.low, -1.5e-5);
  EXPECT_EQ(range.high, 2.0);
  studies::SignatureCurve curve;
  EXPECT_TRUE(quantity_from("angle error of joint 2", curve));
  EXPECT_EQ(curve.joint, 1);
  EXPECT_FALSE(quantity_from("angle error of joint two", curve));
}

}  // namespace
}  // namespace sixdial::report
