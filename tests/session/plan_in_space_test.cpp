// Plans of robots that work in space: every kind, by the ranges of its joints or in a box.
#include "session/plan_in_space.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "geometry/robots/serial.h"
#include "geometry/rotation.h"
#include "geometry/tool.h"
#include "geometry/tool_turn.h"
#include "geometry/units.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "tests/support/paths.h"

namespace sixdial::session {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

geometry::Rig rig_of(const geometry::RobotKind& kind) {
  geometry::Rig rig;
  rig.robot.model = kind.example();
  rig.robot.nominal = rig.robot.model->nominal;
  rig.robot.working_mode = geometry::WorkingMode(rig.robot.model->modes.front().number);
  rig.robot.assembly =
      static_cast<geometry::Assembly>(rig.robot.model->assemblies.front().number);
  rig.instrument.kind = "position";
  rig.instrument.dimensions = rig.robot.model->axes;
  return rig;
}

std::vector<const geometry::RobotKind*> kinds_in_space() {
  std::vector<const geometry::RobotKind*> kinds;
  for (const geometry::RobotKind* each : geometry::robot_kinds()) {
    if (each->example()->axes == 3) kinds.push_back(each);
  }
  return kinds;
}

/// Around where the tool is with every joint in the middle of its range.
TargetBox box_of(const geometry::Rig& rig) {
  Eigen::VectorXd q(rig.robot.model->joint_count());
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const geometry::JointInfo& joint = rig.robot.model->joints[static_cast<std::size_t>(k)];
    q[k] = (joint.low + joint.high) / 2 + 0.3 * (joint.high - joint.low) / 2;
  }
  if (!lists_its_joints(rig)) q.setConstant(q.mean());
  const auto at =
      geometry::Tool(rig).position(rig.robot.nominal, q, rig.robot.assembly).value();
  const Eigen::Vector3d half(8.0, 6.0, 4.0);
  return {at - half, at + half};
}

class EveryRobotInSpace : public testing::TestWithParam<const geometry::RobotKind*> {
 protected:
  geometry::Rig rig_ = rig_of(*GetParam());

  /// Targets are where the nominal robot has its tool, in its own branch, inside of the box and
  /// of the ranges; a plan file gives the same plan back.
  void expect_lawful(const Plan& plan, const std::optional<TargetBox>& box) const {
    constexpr double kRounding_mm = 1e-5;  // nine digits of a radian at 1.5 m, six of a mm
    const geometry::Tool tool(rig_);
    for (const PlanPoint& point : plan.points) {
      const auto at = tool.position(rig_.robot.nominal, point.q, rig_.robot.assembly).value();
      ASSERT_EQ(point.target_mm.size(), 3);
      EXPECT_LT((at - point.target_mm).norm(), kRounding_mm);
      for (Eigen::Index k = 0; k < point.q.size() && lists_its_joints(rig_); ++k) {
        const geometry::JointInfo& joint =
            rig_.robot.model->joints[static_cast<std::size_t>(k)];
        EXPECT_GE(point.q[k], joint.low);
        EXPECT_LE(point.q[k], joint.high);
      }
      if (!box) continue;
      EXPECT_TRUE(((at - box->min_mm).array() > -kRounding_mm).all());
      EXPECT_TRUE(((box->max_mm - at).array() > -kRounding_mm).all());
    }
    EXPECT_EQ(parse_plan(plan_csv(plan, rig_), "plan.csv", rig_), plan);
  }
};

TEST_P(EveryRobotInSpace, GetsRandomPointsInABox) {
  const TargetBox box = box_of(rig_);
  const auto plan = plan_random(rig_, 40, {.box = box, .repeats = 2, .seed = 3});
  ASSERT_TRUE(plan) << describe(plan.error());
  EXPECT_EQ(plan->points.size(), 80U);
  expect_lawful(*plan, box);
  EXPECT_EQ(plan_random(rig_, 40, {.box = box, .repeats = 2, .seed = 3}).value(), *plan);
  EXPECT_NE(plan_random(rig_, 40, {.box = box, .repeats = 2, .seed = 4}).value(), *plan);
}

TEST_P(EveryRobotInSpace, GetsAGridInABox) {
  const TargetBox box = box_of(rig_);
  const auto plan = plan_grid(rig_, 4, 3, {.box = box, .nz = 2, .shuffle = false});
  ASSERT_TRUE(plan) << describe(plan.error());
  ASSERT_EQ(plan->points.size(), 24U);
  expect_lawful(*plan, box);
  EXPECT_NEAR(plan->points.front().target_mm[2], box.min_mm[2], 1e-5);
  EXPECT_NEAR(plan->points.back().target_mm[2], box.max_mm[2], 1e-5);
  double longest_mm = 0.0;  // back and forth: never across the box
  for (std::size_t i = 1; i < 12; ++i) {
    longest_mm = std::max(
        longest_mm, (plan->points[i].target_mm - plan->points[i - 1].target_mm).norm());
  }
  EXPECT_LT(longest_mm, 6.1);
}

TEST_P(EveryRobotInSpace, WithoutABoxDrawsItsJointsOrSaysWhatItNeeds) {
  const auto plan = plan_random(rig_, 30, {.seed = 5});
  if (lists_its_joints(rig_)) {
    ASSERT_TRUE(plan) << describe(plan.error());
    EXPECT_EQ(plan->points.size(), 30U);
    expect_lawful(*plan, std::nullopt);
  } else {
    ASSERT_FALSE(plan);
    EXPECT_THAT(describe(plan.error()), HasSubstr("--box x0 y0 z0 x1 y1 z1"));
  }
  const auto grid = plan_grid(rig_, 2, 2);
  ASSERT_FALSE(grid);
  EXPECT_THAT(describe(grid.error()), HasSubstr("needs a box"));
  for (const auto& refused : {plan, grid}) {
    if (refused) continue;
    EXPECT_THAT(describe(refused.error()), Not(HasSubstr("rectangle")));
  }
}

TEST_P(EveryRobotInSpace, IsRefusedWhereItCannotGo) {
  const TargetBox far{{1e5, 1e5, 1e5}, {2e5, 2e5, 2e5}};
  const auto random = plan_random(rig_, 1, {.box = far});
  ASSERT_FALSE(random);
  EXPECT_THAT(describe(random.error()), HasSubstr("only 0 of 100 random points"));
  const auto grid = plan_grid(rig_, 1, 1, {.box = far});
  ASSERT_FALSE(grid);
  EXPECT_THAT(describe(grid.error()), HasSubstr("in the middle of the box"));
  const auto mode = plan_random(
      rig_, 1, {.box = box_of(rig_), .working_modes = {geometry::WorkingMode(-1, -1)}});
  ASSERT_FALSE(mode);
  EXPECT_THAT(describe(mode.error()), HasSubstr("no working mode"));
}

INSTANTIATE_TEST_SUITE_P(
    , EveryRobotInSpace, testing::ValuesIn(kinds_in_space()),
    [](const auto& each) { return std::string(each.param->name); });

TEST(PlanInSpace, ABoxIsForRobotsInSpaceOnly) {
  const auto plan = plan_random(geometry::default_rig(), 3, {.box = TargetBox{}});
  ASSERT_FALSE(plan);
  EXPECT_THAT(describe(plan.error()), HasSubstr("a box is for robots that work in space"));
}

TEST(PlanInSpace, KeepsToTheRangesOfTheRigFileAndSaysWhereThereAreNone) {
  const std::string text = read_file(test_paths::source_dir() + "/examples/import/ur10.toml");
  const geometry::Rig rig = parse_rig(text, "ur10.toml");
  const Plan plan = plan_random(rig, 20, {.seed = 2}).value();
  const std::string note =
      operator_notes(rig, plan).empty() ? "" : operator_notes(rig, plan)[0];
  EXPECT_EQ(lacks_ranges(rig), note.find("low_deg and high_deg") != std::string::npos);
  const geometry::Rig narrow = parse_rig(
      "[robot]\nmodel = \"serial\"\n[[joint]]\nd_mm = 300\nalpha_deg = 90\nlow_deg = 10\n"
      "high_deg = 20\n[[joint]]\na_mm = 250\nlow_deg = -5\nhigh_deg = 5\n",
      "rig.toml");
  const Plan drawn = plan_random(narrow, 50, {.seed = 2}).value();
  EXPECT_TRUE(operator_notes(narrow, drawn).empty());
  for (const PlanPoint& point : drawn.points) {
    EXPECT_NEAR(point.q[0], 0.2618, 0.0873);
    EXPECT_NEAR(point.q[1], 0.0, 0.0873);
  }
}

TEST(PlanOfSockets, SaysWhichSocketEachPointIsPutInto) {
  geometry::Rig rig = rig_of(*geometry::find_robot_kind("serial"));
  rig.instrument.kind = "socket";
  rig.instrument.sockets = {{.name = "left"}, {.name = "right"}};
  Plan plan = plan_random(rig, 3, {.seed = 4}).value();
  // Of a plan that puts no ball anywhere the column is left out.
  EXPECT_THAT(plan_csv(plan, rig), Not(HasSubstr("socket")));
  plan.points[0].socket = "left";
  plan.points[2].socket = "right";
  const std::string csv = plan_csv(plan, rig);
  EXPECT_THAT(csv, ::testing::StartsWith("set,point,repeat,socket,target_x_mm"));
  const Plan again = parse_plan(csv, "plan.csv", rig);
  EXPECT_EQ(again, plan);
  EXPECT_EQ(again.points[1].socket, "");
  std::string wrong = csv;
  wrong.replace(wrong.find(",right,"), 7, ",rihgt,");
  try {
    static_cast<void>(parse_plan(wrong, "plan.csv", rig));
    FAIL() << "read";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no socket of the rig file"));
    EXPECT_THAT(error.what(), HasSubstr("plan.csv:4"));
  }
}

/// An arm whose instrument measures how its tool is turned.
geometry::Rig posed_rig() {
  geometry::Rig rig = rig_of(geometry::serial);
  rig.instrument.kind = "pose";
  rig.instrument.orientation = "intrinsic xyz";
  return rig;
}

TEST(PlansWithTurns, ReadAndWriteThreeAnglesOfARowOrNone) {
  const geometry::Rig rig = posed_rig();
  const Plan plan = parse_plan(
      "set,point,target_x_mm,target_y_mm,target_z_mm,target_rx_deg,target_ry_deg,target_rz_"
      "deg\n"
      "G1,0,-600,-300,400,90,20,10\nG1,1,-600,-300,400,,,\n",
      "plan.csv", rig);
  ASSERT_TRUE(plan.points[0].target_turn_rad);
  EXPECT_FALSE(plan.points[1].target_turn_rad);
  EXPECT_LT(std::abs((*plan.points[0].target_turn_rad)[1] - 20 * geometry::kRadPerDeg), 1e-15);
  // The joint values of the row are those of its place and its turn, by the nominal arm.
  std::vector<geometry::Pose<double>> X(rig.robot.model->frames.size());
  ASSERT_TRUE(
      rig.robot.model->forward(rig.robot.nominal, plan.points[0].q, rig.robot.assembly, X));
  EXPECT_LT((X[0].p - plan.points[0].target_mm).norm(), 1e-6);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  geometry::turn_about<double>(R, 0, 90 * geometry::kRadPerDeg);
  geometry::turn_about<double>(R, 1, 20 * geometry::kRadPerDeg);
  geometry::turn_about<double>(R, 2, 10 * geometry::kRadPerDeg);
  EXPECT_LT(geometry::turn_between(X[0].R, R), 1e-9);
  const std::string text = plan_csv(plan, layout_of(rig));
  EXPECT_THAT(text, HasSubstr(",target_rx_deg,target_ry_deg,target_rz_deg,q1_rad"));
  const Plan again = parse_plan(text, "plan.csv", rig);
  EXPECT_EQ(again.points[0].target_turn_rad, plan.points[0].target_turn_rad);
  Plan without = plan;
  for (PlanPoint& point : without.points) point.target_turn_rad.reset();
  EXPECT_THAT(plan_csv(without, layout_of(rig)), Not(HasSubstr("target_rx_deg")));
}

TEST(PlansWithTurns, AreRefusedWhereNothingMeasuresThem) {
  const auto message = [](const char* row, const geometry::Rig& rig) -> std::string {
    try {
      static_cast<void>(parse_plan(
          std::string("set,point,target_x_mm,target_y_mm,target_z_mm,target_rx_deg,"
                      "target_ry_deg,target_rz_deg\n") +
              row,
          "plan.csv", rig));
    } catch (const DataError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(
      message("G1,0,-600,-300,400,90,20,10\n", rig_of(geometry::serial)),
      HasSubstr("measures no turn of the tool"));
  EXPECT_THAT(
      message("G1,0,-600,-300,400,90,,10\n", posed_rig()),
      HasSubstr("a turn has three angles"));
  // Poses are measured, but five joints, or three of a delta, cannot take any.
  geometry::Rig five = posed_rig();
  geometry::SerialRobot arm = geometry::serial_robot(*five.robot.model, five.robot.nominal);
  arm.rows.pop_back();
  five.robot.model = geometry::serial_model(arm);
  five.robot.nominal = five.robot.model->nominal;
  geometry::Rig delta = rig_of(*geometry::find_robot_kind("linear_delta"));
  delta.instrument.kind = "pose";
  delta.instrument.orientation = "intrinsic xyz";
  for (const geometry::Rig* rig : {&five, &delta}) {
    EXPECT_THAT(
        message("G1,0,-600,-300,400,90,20,10\n", *rig),
        HasSubstr("this robot cannot turn its tool any way"));
    const Eigen::Vector3d place = box_of(*rig).min_mm;
    EXPECT_EQ(
        message(fmt::format("G1,0,{},{},{},,,\n", place[0], place[1], place[2]).c_str(), *rig),
        "");
  }
}

}  // namespace
}  // namespace sixdial::session
