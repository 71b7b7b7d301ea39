// Whether a target lies in what a session measured.
#include "studies/measured_area.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/tool.h"
#include "report/words/area_words.h"
#include "studies/plausibility.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;

/// A grid of 5 mm over x 16..36, y 35..55 in mode ++.
session::Session grid_session() {
  session::Session session;
  session.rig = geometry::default_rig();
  const geometry::Tool tool(session.rig);
  for (int i = 0; i < 25; ++i) {
    const int row = i / 5;
    const Eigen::Vector2d target_mm(16.0 + 5.0 * (i % 5), 35.0 + 5.0 * row);
    session::Sample sample;
    sample.set = "G1";
    sample.point = i;
    sample.target_mm = target_mm;
    sample.q =
        *tool.inverse(session.rig.robot.nominal, target_mm, session.rig.robot.working_mode);
    session.samples.push_back(sample);
  }
  return session;
}

TEST(MeasuredArea, IsTheHullOfItsPointsAndOneSpacingAround) {
  const session::Session session = grid_session();
  const MeasuredArea area(session);
  EXPECT_EQ(area.outside_mm(Eigen::Vector2d(26.0, 45.0)), 0.0);
  EXPECT_EQ(area.outside_mm(Eigen::Vector2d(16.0, 35.0)), 0.0);
  EXPECT_EQ(area.outside_mm(Eigen::Vector2d(40.0, 45.0)), 0.0) << "within a spacing";
  EXPECT_NEAR(area.outside_mm(Eigen::Vector2d(48.0, 45.0)), 12.0, 1e-9);
  EXPECT_NEAR(area.outside_mm(Eigen::Vector2d(36.0 + 30.0, 55.0 + 40.0)), 50.0, 1e-9);
  EXPECT_TRUE(area.has_mode(session.rig.robot.working_mode));
  EXPECT_FALSE(area.has_mode(geometry::WorkingMode(-1, -1)));
}

TEST(MeasuredArea, CountsTheFittedSetOnlyAndKnowsNothingOfNothing) {
  session::Session session = grid_session();
  session::Sample far = session.samples.front();
  far.set = "G2";
  far.target_mm = Eigen::Vector2d(100.0, 100.0);
  session.samples.push_back(far);
  EXPECT_GT(MeasuredArea(session).outside_mm(Eigen::Vector2d(99.0, 99.0)), 50.0);
  session.samples.clear();
  EXPECT_EQ(MeasuredArea(session).outside_mm(Eigen::Vector2d(0.0, 0.0)), 0.0);
}

TEST(MeasuredArea, LeavesOutTheRowsThatNoFitUses) {
  session::Session session = grid_session();
  session::Sample far = session.samples.front();
  far.point = 25;
  far.target_mm = Eigen::Vector2d(100.0, 100.0);
  far.left_out = true;
  session.samples.push_back(far);
  EXPECT_GT(MeasuredArea(session).outside_mm(Eigen::Vector2d(99.0, 99.0)), 50.0);
  session.samples.back().left_out = false;
  EXPECT_EQ(MeasuredArea(session).outside_mm(Eigen::Vector2d(99.0, 99.0)), 0.0);
}

TEST(MeasuredArea, OfASessionAsReadHasNoCopiedRows) {
  // A row typed twice, the second time with a target elsewhere: which one is right nobody
  // knows.
  session::Session session = testing::measured(
      testing::simple_world(3), session::plan_grid(geometry::default_rig(), 5, 5).value());
  session::Sample copy = session.samples.front();
  copy.point = 99;
  copy.target_mm = Eigen::Vector2d(100.0, 100.0);
  session.samples.push_back(copy);
  int left_out = 0;
  for (const session::Sample& each : plausible(session).session.samples) {
    left_out += each.left_out ? 1 : 0;
  }
  EXPECT_GT(left_out, 0);
  EXPECT_GT(measured_area(session).outside_mm(Eigen::Vector2d(99.0, 99.0)), 50.0);
}

TEST(MeasuredArea, SaysInWordsHowFarOutsideAndInWhichModeNothingWasMeasured) {
  const session::Session session = grid_session();
  const MeasuredArea area(session);
  const geometry::WorkingMode own = session.rig.robot.working_mode;
  EXPECT_EQ(report::outside_words(outside_measured(area, Eigen::Vector2d(26, 45), own), 1), "");
  EXPECT_THAT(
      report::outside_words(outside_measured(area, Eigen::Vector2d(48, 45), own), 1),
      HasSubstr("the target lies 12.0 mm outside of the area that was measured"));
  EXPECT_THAT(
      report::outside_words(
          outside_measured(area, Eigen::Vector2d(26, 45), geometry::WorkingMode(-1, -1)), 1),
      HasSubstr("no sample is in its working mode"));
  session::Plan plan;
  for (const double x : {26.0, 48.0, 56.0}) {
    session::PlanPoint point;
    point.target_mm = Eigen::Vector2d(x, 45.0);
    point.q = session.samples.front().q;
    plan.points.push_back(point);
  }
  EXPECT_THAT(
      report::outside_words(outside_measured(area, plan, session.rig), 3),
      HasSubstr("2 of 3 targets lie up to 20.0 mm outside"));
}

}  // namespace
}  // namespace sixdial::studies
