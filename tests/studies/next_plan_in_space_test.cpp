// What to measure next with an arm: poses within the ranges of its joints and the box that was
// measured, better by what they promise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "geometry/tool.h"
#include "session/plan_in_space.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"
#include "studies/error.h"
#include "studies/next_plan.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kArm =
    "name = \"arm\"\n[robot]\nmodel = \"serial\"\ntool_x_mm = 20\ntool_z_mm = 100\n"
    "[[joint]]\nd_mm = 300\nalpha_deg = 90\nlow_deg = -120\nhigh_deg = 120\n"
    "[[joint]]\na_mm = 250\nlow_deg = 10\nhigh_deg = 80\n"
    "[[joint]]\na_mm = 200\nalpha_deg = 90\nlow_deg = -90\nhigh_deg = -10\n"
    "[[joint]]\nd_mm = 120\nalpha_deg = -90\nlow_deg = -90\nhigh_deg = 90\n"
    "[[joint]]\nalpha_deg = 90\nlow_deg = -90\nhigh_deg = 90\n"
    "[instrument]\nkind = \"position\"\nsd_mm = 0.01\n";

/// `count` poses of an arm that is off by tenths, measured with 0.01 mm of noise.
session::Session measured_arm(int count) {
  session::Session session;
  session.rig = session::parse_rig(kArm, "rig.toml");
  const geometry::Tool tool(session.rig);
  const geometry::Robot& robot = session.rig.robot;
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd truth = robot.nominal;
  for (Eigen::Index i = 0; i < truth.size(); ++i) {
    truth[i] +=
        0.2 * robot.model->parameters[static_cast<std::size_t>(i)].change * normal(engine);
  }
  const session::Plan plan = session::plan_random(session.rig, count, {.seed = 3}).value();
  for (const session::PlanPoint& point : plan.points) {
    session::Sample sample;
    sample.set = point.set;
    sample.point = point.point;
    sample.q = point.q;
    sample.target_mm = point.target_mm;
    geometry::Position p = tool.position(truth, point.q, robot.assembly).value();
    for (double& each : p) each += 0.01 * normal(engine);
    session::set_position(sample, 0, p);
    session.samples.push_back(sample);
  }
  return session;
}

TEST(NextPlanInSpace, KnowsTheToolBetterWithEachPoseThatItAsksFor) {
  const session::Session session = measured_arm(15);
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
  empty.rig = session::parse_rig(kArm, "rig.toml");
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
