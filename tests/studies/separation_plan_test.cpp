// The poses that tell causes apart, as a plan that can be collected. That they do so is shown
// on hidden effects in tests/blind.
#include "studies/separation_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "report/words/plan_words.h"
#include "session/bundle.h"
#include "studies/error.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

session::Session measured(const char* number) {
  return session::read_bundle(
      std::filesystem::path(test_paths::test_data()) / "sessions" / number);
}

TEST(SeparationPlan, IsReadyToBeCollectedAndPromisesMoreThanThereIs) {
  const session::Session session = measured("19");
  const SeparationPlan found = separation_plan(session, {.points = 10, .modes = {}});
  ASSERT_EQ(found.plan.points.size(), 10U);
  EXPECT_EQ(found.plan.points.front().point, 100) << "numbered after the session's G1";
  EXPECT_EQ(
      session::parse_plan(session::plan_csv(found.plan, session.rig), "p.csv", session.rig),
      found.plan);
  EXPECT_TRUE(!found.figures.rival) << "nothing is tied in a clean session";
  EXPECT_GT(found.figures.log_odds_after, found.figures.log_odds_now);
  EXPECT_THAT(report::separation_text(found.figures), ::testing::HasSubstr("shows worst is"));
}

TEST(SeparationPlan, KeepsToTheWorkingModesAskedFor) {
  const session::Session session = measured("19");
  const geometry::WorkingMode plus{+1, +1};
  const SeparationPlan found = separation_plan(session, {.points = 6, .modes = {plus}});
  ASSERT_EQ(found.plan.points.size(), 6U);
  for (const session::PlanPoint& point : found.plan.points) {
    EXPECT_EQ(session::branch_of(session.rig, point).mode, plus);
  }
}

TEST(SeparationPlan, OfAlmostNothingIsRefusedInWords) {
  session::Session session = measured("19");
  session.samples.resize(4);
  try {
    (void)separation_plan(session, {});
    FAIL() << "four samples were enough";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kBadData);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("too few"));
  }
}

}  // namespace
}  // namespace sixdial::studies
