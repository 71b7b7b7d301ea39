// What to measure next: ready to be collected, better by what it promises, and fewer points
// than a grid for the same uncertainty, on sessions as the dials give them.
#include "studies/next_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "report/words/plan_words.h"
#include "studies/error.h"
#include "studies/live_estimate.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;
using testing::measured;
using testing::simple_world;

const geometry::Rig kRig = geometry::default_rig();
const geometry::WorkingMode kPlus{+1, +1};
const geometry::WorkingMode kElbow1Over{-1, +1};
const session::Rectangle kInside{{17, 31}, {39, 65}};

LiveEstimate estimate_of(const session::Session& session) {
  LiveEstimate estimate(session.rig, points_of(session));
  for (const session::Sample& sample : session.samples) estimate.add(sample);
  return estimate;
}

/// Mean distance [mm] between the estimated and the true robot over the workspace.
double error_made(const LiveEstimate& estimate, const geometry::ParameterVector& robot) {
  double sum = 0.0;
  for (const auto& pose : estimate.workspace()) {
    sum += (geometry::forward(estimate.filter().v(), pose.q, pose.assembly)->p_WE -
            geometry::forward(robot, pose.q, pose.assembly)->p_WE)
               .norm();
  }
  return sum / static_cast<double>(estimate.workspace().size());
}

session::Session small_session(int points) {
  return measured(simple_world(7), session::plan_random(kRig, points, {.seed = 7}).value());
}

TEST(NextPlan, IsReadyToBeCollectedAndKeepsItsPromise) {
  session::Session session = small_session(12);
  NextPlanRequest request;
  request.points = 8;
  request.modes = {kPlus, kElbow1Over};
  for (const auto criterion : {calibration::Criterion::kI, calibration::Criterion::kD}) {
    request.criterion = criterion;
    const NextPlan next = next_plan(session, request);
    ASSERT_EQ(next.plan.points.size(), 8U);
    EXPECT_LE(session::stretches_of(kRig, next.plan).size(), 2U);
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_EQ(next.plan.points[i].point, 12 + static_cast<int>(i));
      EXPECT_EQ(next.plan.points[i].set, "G1");
    }
    EXPECT_EQ(
        session::parse_plan(session::plan_csv(next.plan, kRig), "next.csv", kRig), next.plan);

    session::Plan whole = session::plan_random(kRig, 12, {.seed = 7}).value();
    whole.points.insert(whole.points.end(), next.plan.points.begin(), next.plan.points.end());
    const session::Session after = measured(simple_world(7), whole);
    LiveEstimate reached(kRig, points_of(session));  // over the same workspace
    for (const session::Sample& sample : after.samples) reached.add(sample);
    ASSERT_TRUE(next.figures.after);
    const double promised = next.figures.after->mean_mm;
    EXPECT_LT(promised, 0.7 * next.figures.now.mean_mm);
    // The candidates' covariance is the mean of those measured so far, not each its own.
    EXPECT_NEAR(reached.uncertainty().mean_mm / promised, 1.0, 0.35);
    const std::string words = report::next_plan_text(next.figures);
    EXPECT_THAT(words, HasSubstr("12 samples of G1"));
    EXPECT_THAT(words, HasSubstr("with these 8"));
  }
}

/// What the rig leaves open no further point of the robot takes away.
TEST(NextPlan, PromisesNoMoreThanARigAllowsThatIsKnownToATenth) {
  mock_devices::World world = simple_world(7);
  for (geometry::Dial& dial : world.rig.dials) {
    dial.deviations.position_mm = Eigen::Vector2d(0.03, 0.1);
  }
  const session::Session session =
      measured(world, session::plan_random(kRig, 16, {.seed = 7}).value());
  const NextPlan next = next_plan(session, {.points = 8});
  LiveEstimate estimate(session.rig, points_of(session));
  estimate.see_rig(session.samples);
  for (const session::Sample& sample : session.samples) estimate.add(sample);
  EXPECT_NEAR(next.figures.now.mean_mm, estimate.uncertainty().mean_mm, 1e-9);
  const auto& filter = estimate.filter();
  const auto of_rig = calibration::workspace_uncertainty(
      filter.tool(), filter.v(), filter.shared_covariance(), estimate.workspace());
  EXPECT_GT(of_rig.mean_mm, 0.01);
  ASSERT_TRUE(next.figures.after);
  EXPECT_LT(next.figures.after->mean_mm, next.figures.now.mean_mm);
  EXPECT_GT(next.figures.after->mean_mm, of_rig.mean_mm);
}

TEST(NextPlan, OfAnEmptySessionBeginsWithTheRigsOwnWorkspace) {
  session::Session empty;
  empty.rig = kRig;
  const NextPlan next = next_plan(empty, {.points = 6, .modes = {}, .rectangle = {}});
  ASSERT_EQ(next.plan.points.size(), 6U);
  for (const auto& point : next.plan.points) {
    EXPECT_EQ(session::branch_of(kRig, point).mode, kPlus);
    EXPECT_TRUE(((point.target_mm - kInside.min_mm).array() >= -1e-9).all());
    EXPECT_TRUE(((kInside.max_mm - point.target_mm).array() >= -1e-9).all());
  }
}

TEST(NextPlan, AModeInWhichNothingCanBeMeasuredIsRefusedByName) {
  const session::Session session = small_session(6);
  try {
    static_cast<void>(next_plan(
        session, {.points = 4,
                  .modes = {{+1, -1}},
                  .rectangle = session::Rectangle{{17, 31}, {25, 40}}}));
    FAIL() << "planned";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kBadData);
    EXPECT_THAT(error.what(), HasSubstr("working mode +-"));
  }
}

TEST(NextPlan, NeedsFewerPointsThanAGridForTheSameUncertainty) {
  const mock_devices::World world = simple_world(11);
  const session::Plan grid = session::plan_grid(kRig, 10, 10).value();
  const session::Session by_grid = measured(world, grid);
  const LiveEstimate of_grid = estimate_of(by_grid);
  const double limit_mm = of_grid.uncertainty().max_mm;
  EXPECT_LT(limit_mm, 0.005);

  for (const auto& modes : {std::vector{kPlus}, std::vector{kPlus, kElbow1Over}}) {
    session::Plan plan =
        session::plan_random(kRig, 6, {.working_modes = {kPlus}, .seed = 2}).value();
    std::optional<LiveEstimate> reached;
    for (;;) {
      const session::Session so_far = measured(world, plan);
      reached.emplace(kRig, grid.points);  // over the grid's workspace
      for (const session::Sample& sample : so_far.samples) reached->add(sample);
      if (reached->uncertainty().max_mm <= limit_mm) break;
      ASSERT_LT(plan.points.size(), 150U);
      NextPlanRequest request;
      request.points = 5;
      request.modes = modes;
      request.rectangle = kInside;
      const NextPlan next = next_plan(so_far, request);
      plan.points.insert(plan.points.end(), next.plan.points.begin(), next.plan.points.end());
    }
    double most_rad = 0.0;
    for (const session::PlanPoint& point : plan.points) {
      EXPECT_GT(point.q[1], 2.0) << "leg 2 turns on across pi, it does not jump";
      most_rad = std::max(most_rad, point.q[1]);
    }
    EXPECT_GT(most_rad, std::numbers::pi) << "the law was tried";
    const double made_mm = error_made(*reached, world.robot.parameters);
    const double grid_mm = error_made(of_grid, world.robot.parameters);
    std::printf(
        "grid: 100 points, made %.5f mm; plan next in %zu mode(s): %zu points, made %.5f mm\n",
        grid_mm, modes.size(), plan.points.size(), made_mm);
    EXPECT_LE(plan.points.size(), modes.size() == 1 ? 65U : 50U);
    // One draw of errors of about 0.001 mm each.
    EXPECT_LT(made_mm, 3 * limit_mm);
  }
}

}  // namespace
}  // namespace sixdial::studies
