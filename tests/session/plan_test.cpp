#include "session/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "session/trials.h"
#include "tests/session/bundle_text.h"

namespace sixdial::session {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

Plan good(const tl::expected<Plan, PlanRefusal>& plan) {
  if (plan) return *plan;
  ADD_FAILURE() << describe(plan.error());
  return {};
}

/// Laws of every plan: inside the rectangle, angles that put the nominal tool on the target,
/// and an active three that holds for a tool 4 mm off in directions the planner did not try.
void expect_lawful(const geometry::Rig& rig, const Plan& plan, const Rectangle& area) {
  constexpr double kRoundedAngles_mm = 2e-7;  // 1 nrad at 180 mm of arm
  const auto dials = rig.dial_geometries();
  const double reference = geometry::reference_link_angle(rig).value();
  for (const PlanPoint& point : plan.points) {
    EXPECT_TRUE(((point.target_mm - area.min_mm).array() >= 0).all());
    EXPECT_TRUE(((area.max_mm - point.target_mm).array() >= 0).all());
    const auto& v = rig.robot.nominal;
    const auto assembly = geometry::assembly_at(v, point.q, point.target_mm).value();
    const auto pose = geometry::forward(v, point.q, assembly).value();
    EXPECT_LE((pose.p_WE - point.target_mm).norm(), kRoundedAngles_mm);
    const double gamma = geometry::cuboid_angle(rig, reference, pose, 0.0);
    for (int i = 0; i < 16; ++i) {
      const double angle = (i + 0.37) * std::numbers::pi / 8;
      const geometry::CuboidPose off{
          point.target_mm + 3.6 * Vector2d(std::cos(angle), std::sin(angle)), gamma};
      std::vector<geometry::DialReading> readings;
      for (std::size_t d = 0; d < dials.size(); ++d) {
        const auto contact = geometry::touch(dials[d], off, rig.cuboid.side_mm);
        if (contact) readings.push_back({static_cast<int>(d), contact->displacement_mm, 0.002});
      }
      EXPECT_TRUE(
          geometry::best_active_three(dials, readings, rig.cuboid.side_mm, gamma).has_value());
    }
  }
}

TEST(RandomPlan, OfTheDefaultRectangleIsLawfulForManySeeds) {
  const geometry::Rig rig = geometry::default_rig();
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const char* set : {"G1", "G2"}) {
      PlanOptions options;
      options.set = set;
      options.seed = seed;
      const Plan plan = good(plan_random(rig, 50, options));
      ASSERT_EQ(plan.points.size(), 50U);
      expect_lawful(rig, plan, options.rectangle);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 40);
}

TEST(RandomPlan, IsRepeatableAndDiffersBySeedAndSet) {
  const geometry::Rig rig = geometry::default_rig();
  const Plan a = good(plan_random(rig, 20, {.seed = 5}));
  EXPECT_EQ(a, good(plan_random(rig, 20, {.seed = 5})));
  const Plan b = good(plan_random(rig, 20, {.seed = 6}));
  const Plan c = good(plan_random(rig, 20, {.set = "G2", .seed = 5}));
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NE(a.points[i].target_mm, b.points[i].target_mm);
    EXPECT_NE(a.points[i].target_mm, c.points[i].target_mm);
  }
}

TEST(RandomPlan, CoversTheRectangleEvenly) {
  const Plan plan = good(plan_random(geometry::default_rig(), 400, {.seed = 11}));
  std::array<int, 4> quadrants{};
  for (const PlanPoint& point : plan.points) {
    const std::size_t right = point.target_mm.x() > 28 ? 1 : 0;
    const std::size_t upper = point.target_mm.y() > 48 ? 2 : 0;
    ++quadrants[right + upper];
  }
  // 100 each, standard deviation 8.7; five of them, as some draws near corners are refused.
  for (const int count : quadrants) EXPECT_NEAR(count, 100, 44);
}

TEST(RandomPlan, DrawsAgainWhereAPointCannotBeMeasured) {
  // Half of this rectangle lies beyond the dials.
  const Rectangle wide{{-20, 30}, {40, 66}};
  const geometry::Rig rig = geometry::default_rig();
  const Plan plan = good(plan_random(rig, 50, {.rectangle = wide, .seed = 3}));
  EXPECT_EQ(plan.points.size(), 50U);
  expect_lawful(rig, plan, wide);
}

TEST(RandomPlan, GivesUpAndSaysWhyWhereNothingCanBeMeasured) {
  const auto plan =
      plan_random(geometry::default_rig(), 3, {.rectangle = {{-60, 80}, {-50, 90}}, .seed = 3});
  ASSERT_FALSE(plan.has_value());
  EXPECT_THAT(describe(plan.error()), HasSubstr("only 0 of 300 random points can be measured"));
}

TEST(GridPlan, OfTheDefaultRectangleIsLawfulAndHasEveryNodeOnce) {
  const geometry::Rig rig = geometry::default_rig();
  for (const bool shuffle : {false, true}) {
    const Plan plan = good(plan_grid(rig, 7, 10, {.shuffle = shuffle, .seed = 4}));
    ASSERT_EQ(plan.points.size(), 70U);
    expect_lawful(rig, plan, {});
    std::set<std::pair<double, double>> nodes;
    for (const PlanPoint& point : plan.points) {
      nodes.emplace(point.target_mm.x(), point.target_mm.y());
    }
    EXPECT_EQ(nodes.size(), 70U);
    EXPECT_TRUE(nodes.contains({17, 31}));
    EXPECT_TRUE(nodes.contains({39, 65}));
  }
}

TEST(GridPlan, InSerpentineOrderMovesOneStepAtATimeAndShuffledDoesNot) {
  const geometry::Rig rig = geometry::default_rig();
  const auto longest_step = [](const Plan& plan) {
    double longest = 0;
    for (std::size_t i = 1; i < plan.points.size(); ++i) {
      longest =
          std::max(longest, (plan.points[i].target_mm - plan.points[i - 1].target_mm).norm());
    }
    return longest;
  };
  EXPECT_LE(longest_step(good(plan_grid(rig, 7, 10, {.shuffle = false}))), 4.0 + 1e-6);
  EXPECT_GT(longest_step(good(plan_grid(rig, 7, 10, {.shuffle = true}))), 20.0);
}

TEST(GridPlan, KeepsItsMargin) {
  const Plan plan =
      good(plan_grid(geometry::default_rig(), 2, 2, {.margin_mm = 3, .shuffle = false}));
  EXPECT_EQ(plan.points[0].target_mm, Vector2d(19, 33));
  EXPECT_EQ(plan.points[3].target_mm, Vector2d(19, 63));
}

TEST(GridPlan, RefusesAPointOutOfReachByNumberAndPlace) {
  const auto plan = plan_grid(
      geometry::default_rig(), 3, 1,
      {.rectangle = {{28, 48}, {128, 48}}, .margin_mm = 0, .shuffle = false});
  ASSERT_FALSE(plan.has_value());
  EXPECT_THAT(describe(plan.error()), HasSubstr("point 1 at (78.000, 48.000) mm"));
  const auto far = plan_grid(
      geometry::default_rig(), 1, 1,
      {.rectangle = {{280, 48}, {280, 48}}, .margin_mm = 0, .shuffle = false});
  ASSERT_FALSE(far.has_value());
  EXPECT_THAT(describe(far.error()), HasSubstr("cannot reach"));
}

TEST(GridPlan, RefusesAPointWithTooFewContactsAndNamesTheDials) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.resize(3);  // A, B and C: no two on one face
  const auto plan = plan_grid(rig, 1, 1, {.shuffle = false});
  ASSERT_FALSE(plan.has_value());
  EXPECT_THAT(describe(plan.error()), HasSubstr("fewer than two dials on one face"));

  rig = geometry::default_rig();
  for (geometry::Dial& dial : rig.dials) dial.geometry.position_mm -= 30 * dial.geometry.axis;
  const auto away = plan_grid(rig, 1, 1, {.shuffle = false});
  ASSERT_FALSE(away.has_value());
  EXPECT_THAT(describe(away.error()), HasSubstr("F: the cuboid is out of the plunger's reach"));
}

TEST(GridPlan, RefusesToPushADialBeyondItsTravel) {
  geometry::Rig rig = geometry::default_rig();
  for (geometry::Dial& dial : rig.dials) dial.geometry.travel_mm = 18;
  const auto plan = plan_grid(rig, 1, 1, {.shuffle = false});
  ASSERT_FALSE(plan.has_value());
  EXPECT_THAT(describe(plan.error()), HasSubstr("beyond its travel of 18 mm"));
}

TEST(GridPlan, AsksForMoreRoomForARobotThatIsFurtherOff) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.resize(4);  // A, B on the sides, C and D below: 16 mm deep in the middle
  rig.dials.erase(rig.dials.begin());
  EXPECT_TRUE(plan_grid(rig, 1, 1, {.robot_error_mm = 10}).has_value());
  EXPECT_FALSE(plan_grid(rig, 1, 1, {.robot_error_mm = 17}).has_value());
}

TEST(GridPlan, ForAnInstrumentNeedsNoContacts) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.clear();
  EXPECT_TRUE(plan_grid(rig, 2, 2, {.rectangle = {{-10, 60}, {10, 80}}}).has_value());
}

TEST(Plan, RefusesARequestWithoutSense) {
  const geometry::Rig rig = geometry::default_rig();
  EXPECT_FALSE(plan_grid(rig, 0, 5).has_value());
  EXPECT_FALSE(plan_random(rig, -1).has_value());
  EXPECT_FALSE(plan_random(rig, 5, {.set = ""}).has_value());
  EXPECT_FALSE(plan_random(rig, 5, {.rectangle = {{40, 30}, {16, 66}}}).has_value());
  EXPECT_FALSE(plan_random(rig, 5, {.margin_mm = 12.5}).has_value());
  EXPECT_FALSE(plan_random(rig, 5, {.margin_mm = std::nan("")}).has_value());
  EXPECT_FALSE(plan_random(rig, 5, {.repeats = 0}).has_value());
  EXPECT_FALSE(plan_random(rig, 5, {.every = 0}).has_value());
}

TEST(Plan, RepeatsAPointAndComesFromBothSides) {
  const geometry::Rig rig = geometry::default_rig();
  const Plan plan = good(plan_random(
      rig, 6,
      {.first_point = 100,
       .repeats = 2,
       .approach = ApproachRule::kBothSides,
       .every = 3,
       .seed = 2}));
  ASSERT_EQ(plan.points.size(), 2U * 4 + 4U * 2);
  std::map<int, std::vector<PlanPoint>> by_point;
  for (const PlanPoint& point : plan.points) by_point[point.point].push_back(point);
  ASSERT_EQ(by_point.size(), 6U);
  for (const auto& [number, points] : by_point) {
    const bool both = (number - 100) % 3 == 0;
    ASSERT_EQ(points.size(), both ? 4U : 2U);
    for (std::size_t r = 0; r < points.size(); ++r) {
      EXPECT_EQ(points[r].repeat, static_cast<int>(r));
      EXPECT_NE(points[r].approach[0], 0);
      EXPECT_EQ(points[r].target_mm, points[0].target_mm);
    }
    EXPECT_EQ(points[0].approach != points[1].approach, both);
  }
}

TEST(Plan, AlternatesSidesSoThatTheJointsDoNotGoTogether) {
  const Plan plan = good(plan_random(
      geometry::default_rig(), 40, {.approach = ApproachRule::kAlternate, .seed = 2}));
  int sum1 = 0;
  int sum2 = 0;
  int product = 0;
  for (const PlanPoint& point : plan.points) {
    sum1 += point.approach[0];
    sum2 += point.approach[1];
    product += point.approach[0] * point.approach[1];
  }
  EXPECT_EQ(sum1, 0);
  EXPECT_EQ(sum2, 0);
  EXPECT_EQ(product, 0);
}

TEST(Plan, InAnotherWorkingModeTakesTheAnglesOfThatMode) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.clear();
  const geometry::WorkingMode mode{+1, -1};
  const Plan plan = good(plan_random(rig, 10, {.working_modes = {mode}, .seed = 8}));
  for (const PlanPoint& point : plan.points) {
    const auto& v = rig.robot.nominal;
    const auto assembly = geometry::assembly_at(v, point.q, point.target_mm).value();
    EXPECT_EQ(geometry::working_mode_of(v, point.q, assembly).value(), mode);
  }
}

const geometry::WorkingMode kPlus{+1, +1};
const geometry::WorkingMode kElbow1Over{-1, +1};
const geometry::WorkingMode kElbow2Over{+1, -1};

TEST(Plan, OfSeveralWorkingModesHasEveryPointInItsModeAndOneChangeOnly) {
  const geometry::Rig rig = geometry::default_rig();
  const Plan grid = good(plan_grid(rig, 4, 5, {.working_modes = {kPlus, kElbow1Over}}));
  const Plan random =
      good(plan_random(rig, 20, {.working_modes = {kElbow1Over, kPlus}, .seed = 3}));
  int tried = 0;
  for (const Plan* plan : {&grid, &random}) {
    ASSERT_EQ(plan->points.size(), 40U);
    expect_lawful(rig, *plan, {});
    const auto stretches = stretches_of(rig, *plan);
    ASSERT_EQ(stretches.size(), 2U);
    EXPECT_EQ(stretches[0].points, 20U);
    EXPECT_EQ(stretches[1].first, 20U);
    const bool plus_first = plan == &grid;
    EXPECT_EQ(stretches[0].branch.mode, plus_first ? kPlus : kElbow1Over);
    EXPECT_EQ(stretches[1].branch.mode, plus_first ? kElbow1Over : kPlus);
    for (std::size_t i = 0; i < plan->points.size(); ++i) {
      EXPECT_EQ(plan->points[i].point, static_cast<int>(i));
      ++tried;
    }
    const auto notes = operator_notes(rig, *plan);
    ASSERT_EQ(notes.size(), 2U);
    EXPECT_THAT(notes[1], HasSubstr("before G1 point 20 an operator"));
  }
  EXPECT_EQ(tried, 80);
  EXPECT_TRUE(operator_notes(rig, good(plan_grid(rig, 2, 2))).empty());
}

TEST(Plan, IsRefusedWhereOneModeCannotBeMeasuredAndSaysWhich) {
  const geometry::Rig rig = geometry::default_rig();
  ASSERT_TRUE(plan_grid(rig, 4, 5, {.working_modes = {kPlus}}).has_value());
  const auto plan = plan_grid(rig, 4, 5, {.working_modes = {kPlus, kElbow2Over}});
  ASSERT_FALSE(plan.has_value());
  EXPECT_THAT(describe(plan.error()), HasSubstr("in working mode +-: "));
  const auto twice = plan_random(rig, 4, {.working_modes = {kPlus, kElbow1Over, kPlus}});
  ASSERT_FALSE(twice.has_value());
  EXPECT_THAT(describe(twice.error()), HasSubstr("working mode ++ is named twice"));
}

TEST(Plan, KeepsJointAnglesContinuousAcrossPi) {
  const Plan plan = good(plan_random(geometry::default_rig(), 200, {.seed = 9}));
  double most = 0;
  for (const PlanPoint& point : plan.points) {
    EXPECT_GT(point.q[1], 2.0);
    most = std::max(most, point.q[1]);
  }
  EXPECT_GT(most, std::numbers::pi) << "the law was tried";
}

TEST(PlanFile, ReadsBackWhatItWrote) {
  const geometry::Rig rig = geometry::default_rig();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Plan plan = good(plan_random(
        rig, 30, {.repeats = 2, .approach = ApproachRule::kBothSides, .seed = seed}));
    EXPECT_EQ(parse_plan(plan_csv(plan, layout_of(rig)), "plan.csv", rig), plan);
  }
}

TEST(PlanFile, SaysTheModeOfEachPointAndReadsBackTheSamePlan) {
  const geometry::Rig rig = geometry::default_rig();
  const Plan plan =
      good(plan_random(rig, 10, {.working_modes = {kPlus, kElbow1Over}, .seed = 4}));
  const std::string text = plan_csv(plan, rig);
  EXPECT_THAT(text, HasSubstr(",mode\n"));
  EXPECT_THAT(text, HasSubstr(",++\n"));
  EXPECT_THAT(text, HasSubstr(",-+\n"));
  EXPECT_EQ(parse_plan(text, "plan.csv", rig), plan);
  EXPECT_EQ(parse_plan(plan_csv(plan, layout_of(rig)), "plan.csv", rig), plan);
}

TEST(PlanFile, TakesTheModeOfARowWithoutAngles) {
  const geometry::Rig rig = geometry::default_rig();
  const Plan plan = parse_plan(
      "set,point,target_x_mm,target_y_mm,mode\nG1,0,28,48,-+\nG1,1,28,48,\n", "plan.csv", rig);
  ASSERT_EQ(plan.points.size(), 2U);
  EXPECT_EQ(branch_of(rig, plan.points[0]).mode, kElbow1Over);
  EXPECT_EQ(branch_of(rig, plan.points[1]).mode, kPlus);
}

TEST(PlanFile, IsRefusedWhereAnglesAndModeContradictEachOther) {
  const geometry::Rig rig = geometry::default_rig();
  std::string text = plan_csv(good(plan_grid(rig, 1, 1)), rig);
  const auto refused = [&](const std::string& mode) {
    std::string changed = text;
    changed.replace(changed.rfind("++"), 2, mode);
    return error_of([&] { (void)parse_plan(changed, "plan.csv", rig); });
  };
  const DataError wrong = refused("-+");
  EXPECT_EQ(wrong.field, "mode");
  EXPECT_EQ(wrong.line, 2);
  EXPECT_THAT(wrong.what(), HasSubstr("the angles are those of working mode ++"));
  EXPECT_THAT(refused("+").what(), HasSubstr("'+' is no working mode"));
}

TEST(PlanFile, ComputesAnglesThatAreLeftOut) {
  const geometry::Rig rig = geometry::default_rig();
  const Plan plan = parse_plan(
      "set,point,target_x_mm,target_y_mm\nG1,0,28,48\nG1,1,16,30\n", "plan.csv", rig);
  ASSERT_EQ(plan.points.size(), 2U);
  constexpr double kClosure_mm = 1e-11;
  for (const PlanPoint& point : plan.points) {
    const auto pose =
        geometry::forward(rig.robot.nominal, point.q, geometry::Assembly::kLeft).value();
    EXPECT_LE((pose.p_WE - point.target_mm).norm(), kClosure_mm);
  }
  EXPECT_GT(plan.points[1].q[1], std::numbers::pi);
}

TEST(PlanFile, IsRefusedWithLineAndColumn) {
  const geometry::Rig rig = geometry::default_rig();
  const std::string head = "set,point,repeat,target_x_mm,target_y_mm,theta1_rad,theta2_rad\n";
  const auto refused = [&](const std::string& text) {
    return error_of([&] { (void)parse_plan(text, "plan.csv", rig); });
  };
  DataError error = refused(head + "G1,0,0,28,48,,\nG1,0,0,28,49,,\n");
  EXPECT_EQ(std::pair(error.line, error.column), std::pair(3, 4));
  error = refused(head + "G1,0,0,280,48,,\n");
  EXPECT_EQ(std::pair(error.line, error.column), std::pair(2, 8));
  EXPECT_THAT(error.what(), HasSubstr("the robot cannot take (280, 48) mm"));
  error = refused(head + "G1,0,0,28,48,1.5,0.1\n");
  EXPECT_EQ(std::pair(error.line, error.column), std::pair(2, 14));
  error = refused(head + "G1,0,0,28,48,1.5,\n");
  EXPECT_EQ(error.field, "theta2_rad");
  error = refused(head + "G1,zero,0,28,48,,\n");
  EXPECT_THAT(error.what(), HasSubstr("'zero' does not fit"));
  error = refused("set,pont,target_x_mm,target_y_mm\n");
  EXPECT_THAT(error.what(), HasSubstr("the nearest known one is 'point'"));
  error = refused(head);
  EXPECT_THAT(error.what(), HasSubstr("no points"));
}

TEST(ApproachRules, ReadBackTheirNames) {
  for (const ApproachRule rule :
       {ApproachRule::kAsItComes, ApproachRule::kAlternate, ApproachRule::kBothSides}) {
    EXPECT_EQ(approach_rule_from(to_string(rule)), rule);
  }
  EXPECT_FALSE(approach_rule_from("sideways").has_value());
}

}  // namespace
}  // namespace sixdial::session
