// What plan next, plan separate and the live estimate told in an earlier version is read whole
// and written as it was.
#include "report/documents/plan_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/documents/estimate_json.h"
#include "report/words/estimate_words.h"
#include "report/words/plan_words.h"
#include "studies/error.h"
#include "tests/report/documents/stored_document.h"

namespace sixdial::report {
namespace {

using ::testing::HasSubstr;

/// Without the plan itself, which stands beside the figures.
Json figures_of(const char* name) {
  Json answer = stored_document(name);
  answer.erase("plan_csv");
  answer.erase("notes");
  return answer;
}

TEST(PlanDocument, OfPlanNextIsReadAndWrittenAsItWas) {
  const studies::NextPlanFigures figures =
      next_plan_from_json(stored_document("plan_next.json"));
  EXPECT_EQ(figures.points, 4);
  EXPECT_EQ(figures.steps.size(), 4U);
  ASSERT_TRUE(figures.after);
  EXPECT_LT(figures.after->max_mm, figures.now.max_mm);
  expect_same_document(to_json(figures), figures_of("plan_next.json"));
  EXPECT_THAT(next_plan_text(figures), HasSubstr("with these 4 points (I-optimal)"));
}

TEST(PlanDocument, OfPlanSeparateIsReadAndWrittenAsItWas) {
  const studies::SeparationFigures figures =
      separation_from_json(stored_document("plan_separate.json"));
  EXPECT_FALSE(figures.rival);
  EXPECT_TRUE(figures.size_assumed);
  EXPECT_EQ(figures.by_point.size(), 4U);
  expect_same_document(to_json(figures), figures_of("plan_separate.json"));
  EXPECT_THAT(separation_text(figures), HasSubstr("shows worst is"));
}

TEST(EstimateDocument, IsReadAndWrittenAsItWas) {
  const Json stored = stored_document("estimate.json");
  const studies::EstimateSummary estimate = estimate_from_json(stored);
  EXPECT_EQ(estimate.samples, 40);
  EXPECT_EQ(estimate.parameters.size(), stored["parameters"].size());
  expect_same_document(to_json(estimate), stored);
  EXPECT_THAT(
      estimate_summary(estimate),
      HasSubstr("after 40 samples: positions are known to 0.0105 mm"));
  EXPECT_THAT(estimate_parameters(estimate).back(), HasSubstr("dtheta2 -1.3249 +- 0.1482 deg"));
}

TEST(EstimateDocument, HasTheRigWhereItsFileSaysHowWellItIsKnown) {
  studies::EstimateSummary estimate = estimate_from_json(stored_document("estimate.json"));
  EXPECT_FALSE(estimate.position_sd_rig_mm);
  estimate.position_sd_rig_mm = 0.004;
  estimate.rig = {
      {.name = "place of dial C along its axis",
       .unit = "mm",
       .off = 0.02,
       .sd = 0.01,
       .known_sd = 0.03,
       .stated = true}};
  const Json document = to_json(estimate);
  EXPECT_EQ(document["position_sd_mm"]["of_rig"], 0.004);
  const studies::EstimateSummary again = estimate_from_json(document);
  EXPECT_EQ(to_json(again), document);
  EXPECT_EQ(again.rig.value().front().name, estimate.rig->front().name);
  EXPECT_THAT(estimate_summary(again), HasSubstr("the rig alone 0.0080 mm"));
}

TEST(EstimateDocument, WithoutAConditionOrAWorstPlaceKeepsThatEmpty) {
  studies::EstimateSummary estimate = estimate_from_json(stored_document("estimate.json"));
  estimate.condition.reset();
  estimate.worst_mm.reset();
  estimate.undetermined = {"d", "x0"};
  const studies::EstimateSummary again = estimate_from_json(to_json(estimate));
  EXPECT_FALSE(again.condition);
  EXPECT_FALSE(again.worst_mm);
  EXPECT_THAT(
      estimate_summary(again),
      HasSubstr("condition number infinite; not determined yet: d, x0"));
  Json broken = to_json(estimate);
  broken.erase("samples");
  EXPECT_THROW(static_cast<void>(estimate_from_json(broken)), studies::StudyError);
}

}  // namespace
}  // namespace sixdial::report
