// Working modes pooled in one session: what each alone and all together tell about the robot,
// as results say it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/sections/sections_of_studies.h"
#include "report/words/calibration_words.h"
#include "session/trials.h"
#include "studies/assessment.h"
#include "studies/mode_assessment.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using testing::measured;
using testing::simple_world;

const geometry::WorkingMode kPlus{+1, +1};
const geometry::WorkingMode kElbow1Over{-1, +1};

session::Session session_in(std::vector<geometry::WorkingMode> modes, int points) {
  const auto each = points / static_cast<int>(modes.size());
  const auto plan = session::plan_random(
      geometry::default_rig(), each, {.working_modes = std::move(modes), .seed = 3});
  return measured(simple_world(5), plan.value());
}

Assessment assessed(const session::Session& session, const std::string& space_name) {
  const auto trials = session::trials_of(session, "G1");
  const auto space = space_of(space_name, trials, session, 0.003);
  calibration::IdentifySettings settings;
  const auto found =
      calibration::identify(*calibration::find_identifier("lm"), space, settings);
  return assess(
      space, found.fit, calibration::weighting_of(space, settings), trials, trials,
      session.rig);
}

TEST(WorkingModes, PooledDetermineTheRobotBetterThanAnyOneWithAsManyPoints) {
  for (const char* space : {"positions", "dials"}) {
    const Assessment plus = assessed(session_in({kPlus}, 60), space);
    const Assessment over = assessed(session_in({kElbow1Over}, 60), space);
    const Assessment both = assessed(session_in({kPlus, kElbow1Over}, 60), space);
    const auto pooled = both.identifiability.condition;
    for (const Assessment& alone : {plus, over}) {
      ASSERT_EQ(alone.working_modes.size(), 1U);
      const auto condition = alone.identifiability.condition;
      EXPECT_NEAR(alone.working_modes[0].condition.value() / condition, 1.0, 1e-6);
      EXPECT_LT(pooled, 0.8 * condition) << space;
    }
    // Of one session: each mode's rows alone against all.
    ASSERT_EQ(both.working_modes.size(), 2U);
    for (const WorkingModeRow& each : both.working_modes) {
      EXPECT_EQ(each.samples, 30);
      EXPECT_LT(pooled, 0.8 * each.condition.value()) << space;
    }
    std::printf(
        "%s: condition ++ %.0f, -+ %.0f, pooled %.0f\n", space, plus.identifiability.condition,
        over.identifiability.condition, pooled);
  }
}

TEST(WorkingModes, AreInWhatPeopleReadAndInTheReport) {
  const Assessment both = assessed(session_in({kPlus, kElbow1Over}, 40), "positions");
  const auto lines = report::assessment_lines(both);
  EXPECT_THAT(lines, ::testing::Contains(HasSubstr("condition number by working mode: ++ ")));
  EXPECT_THAT(lines, ::testing::Contains(HasSubstr("(20 samples); pooled ")));
  int tables = 0;
  for (const auto& section : report::assessment_sections(both, std::nullopt)) {
    for (const auto& block : section.blocks) {
      const auto* table = std::get_if<report::Table>(&block);
      if (table == nullptr || table->id != "working_modes") continue;
      ++tables;
      EXPECT_EQ(table->rows.size(), 3U);  // two modes and pooled
    }
  }
  EXPECT_EQ(tables, 1);
  const Assessment one = assessed(session_in({kPlus}, 40), "positions");
  EXPECT_THAT(
      report::assessment_lines(one),
      ::testing::Not(::testing::Contains(HasSubstr("by working mode"))));
}

TEST(WorkingModes, AModeOfTooFewPointsHasNoConditionOfItsOwn) {
  session::Session session = session_in({kPlus, kElbow1Over}, 40);
  session.samples.resize(22);  // two of the second mode
  const Assessment assessment = assessed(session, "positions");
  ASSERT_EQ(assessment.working_modes.size(), 2U);
  EXPECT_FALSE(assessment.working_modes[1].condition);
  EXPECT_THAT(
      report::working_modes_line(
          assessment.working_modes, assessment.identifiability.condition),
      HasSubstr("-+ infinite (2 samples)"));
}

}  // namespace
}  // namespace sixdial::studies
