// What to measure next with an arm: poses within the ranges of its joints and the box that was
// measured, better by what they promise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/tool.h"
#include "session/plan_in_space.h"
#include "session/rig_file.h"
#include "studies/error.h"
#include "studies/next_plan.h"
#include "tests/support/arm_session.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(NextPlanInSpace, KnowsTheToolBetterWithEachPoseThatItAsksFor) {
  const session::Session session = session::arm_session(15, 15);
  const NextPlan next = next_plan(session, {.points = 6});
  ASSERT_EQ(next.plan.points.size(), 6U);
  EXPECT_EQ(next.figures.samples, 15);
  double before_mm = next.figures.now.mean_mm;
  for (const NextStep& step : next.figures.steps) {
    EXPECT_LT(step.after.mean_mm, before_mm);
    before_mm = step.after.mean_mm;
    EXPECT_EQ(step.target_mm.size(), 3);
  }
  EXPECT_LT(next.figures.after->mean_mm, 0.9 * next.figures.now.mean_mm);
  const geometry::Tool tool(session.rig);
  for (std::size_t i = 0; i < 6; ++i) {
    const session::PlanPoint& point = next.plan.points[i];
    EXPECT_EQ(point.point, 15 + static_cast<int>(i));
    for (Eigen::Index k = 0; k < point.q.size(); ++k) {
      const geometry::JointInfo& joint =
          session.rig.robot.model->joints[static_cast<std::size_t>(k)];
      EXPECT_GE(point.q[k], joint.low);
      EXPECT_LE(point.q[k], joint.high);
    }
    const auto at =
        tool.position(session.rig.robot.nominal, point.q, session.rig.robot.assembly).value();
    EXPECT_LT((at - point.target_mm).norm(), 1e-5);
  }
  EXPECT_EQ(
      session::parse_plan(session::plan_csv(next.plan, session.rig), "next.csv", session.rig),
      next.plan);
}

TEST(NextPlanInSpace, OfAnEmptySessionDrawsTheJointsRanges) {
  session::Session empty;
  empty.rig = session::parse_rig(session::kSmallArm, "rig.toml");
  const NextPlan next = next_plan(empty, {.points = 8});
  EXPECT_EQ(next.plan.points.size(), 8U);
  EXPECT_EQ(next.figures.samples, 0);
}

TEST(NextPlanInSpace, ADeltaWithoutASessionSaysWhatItNeeds) {
  session::Session empty;
  empty.rig.robot.model = geometry::find_robot_kind("linear_delta")->example();
  empty.rig.robot.nominal = empty.rig.robot.model->nominal;
  empty.rig.instrument.kind = "position";
  empty.rig.instrument.dimensions = 3;
  try {
    static_cast<void>(next_plan(empty, {.points = 3}));
    FAIL() << "planned";
  } catch (const StudyError& error) {
    EXPECT_THAT(error.what(), HasSubstr("does not say which joint values"));
    EXPECT_THAT(error.what(), Not(HasSubstr("++")));
  }
}

}  // namespace
}  // namespace sixdial::studies
