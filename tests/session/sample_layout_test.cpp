// Samples of any robot and instrument: the columns follow from the layout's lists.
#include "session/sample_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "session/columns.h"
#include "tests/session/bundle_text.h"

namespace sixdial::session {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Five turning joints and one that slides, two dials, positions in space.
SampleLayout arm() {
  std::vector<Joint> joints;
  for (int i = 1; i <= 5; ++i) joints.push_back({"q" + std::to_string(i), "rad", true});
  joints.push_back({"q6", "mm"});
  std::vector<geometry::Dial> dials(2);
  dials[0].id = "A";
  dials[1].id = "B";
  return make_layout(std::move(joints), dials, {"x", "y", "z"});
}

std::vector<std::string> names_of(const std::vector<HeaderColumn>& columns) {
  std::vector<std::string> names;
  for (const HeaderColumn& column : columns) names.push_back(column.name);
  return names;
}

TEST(SampleLayout, OfTheFiveBarHasTheColumnsOfTheSpec) {
  const SampleLayout layout = layout_of(geometry::default_rig());
  std::string header;
  for (const std::string& name : names_of(spec_columns(layout, true, false))) {
    header += (header.empty() ? "" : ",") + name;
  }
  EXPECT_EQ(header, kHeader);
  EXPECT_EQ(names_of(spec_columns(layout, false, true)).back(), "y_mm");
}

TEST(SampleLayout, OfAnArmNamesEveryJointAndCoordinate) {
  EXPECT_THAT(
      names_of(spec_columns(arm(), true, true)),
      ElementsAre(
          "set", "point", "repeat", "time_utc", "q1_rad", "q2_rad", "q3_rad", "q4_rad",
          "q5_rad", "q6_mm", "target_x_mm", "target_y_mm", "target_z_mm", "approach1",
          "approach2", "approach3", "approach4", "approach5", "approach6", "temperature_c",
          "dial_A_mm", "dial_B_mm", "x_mm", "y_mm", "z_mm"));
}

TEST(SampleLayout, ReadsAnglesInDegreesWhereARobotAllowsIt) {
  const CsvTable table =
      read_csv("set,q1_rad,q2_deg,q3_rad,q4_rad,q5_rad,q6_mm,x_mm,y_mm,z_mm\n", "s.csv");
  std::vector<Mistake> mistakes;
  const auto columns = read_header(table.header, arm(), mistakes);
  EXPECT_THAT(mistakes, IsEmpty());
  EXPECT_EQ(columns[2].column, SampleColumn::kJoint);
  EXPECT_EQ(columns[2].index, 1U);
  EXPECT_NEAR(columns[2].per_unit, 57.29577951308232, 1e-12);  // degrees in a radian
  EXPECT_EQ(columns[9].column, SampleColumn::kChannel);
  EXPECT_EQ(columns[9].index, 4U);  // after A, B, x, y
}

TEST(SampleLayout, SaysWhatAHeaderLacks) {
  const auto mistakes_of = [](const std::string& header) {
    const std::string text = header + "\n";
    const CsvTable table = read_csv(text, "s.csv");
    std::vector<Mistake> mistakes;
    (void)read_header(table.header, arm(), mistakes);
    std::string all;
    for (const Mistake& each : mistakes) all += to_string("s.csv", each) + "\n";
    return all;
  };
  EXPECT_THAT(
      mistakes_of("set,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,dial_A_mm"),
      HasSubstr("q6_mm: the column is missing; add the sixth joint's encoder value in mm"));
  EXPECT_THAT(
      mistakes_of("set,q1_rad,q1_deg,q2_rad,q3_rad,q4_rad,q5_rad,q6_mm,dial_A_mm"),
      HasSubstr("q1_deg: q1_rad gives the same joint"));
  EXPECT_THAT(
      mistakes_of("set,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_mm,x_mm,z_mm"),
      HasSubstr("y_mm: the column is missing; a position needs x_mm, y_mm and z_mm"));
  EXPECT_THAT(
      mistakes_of("set,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_mm"),
      HasSubstr("there are no dial columns and no x_mm, y_mm, z_mm"));
}

TEST(SampleLayout, RefusesASampleOfAnotherRobot) {
  Sample sample;
  sample.set = "G1";
  sample.q = Eigen::VectorXd::Ones(6);
  sample.channels.resize(2);
  EXPECT_EQ(sample_problem(arm(), sample), "");
  set_position(sample, 2, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(sample_problem(arm(), sample), "");
  EXPECT_EQ(position_of(sample, 2), Eigen::Vector3d(1, 2, 3));
  sample.target_mm = Eigen::Vector2d(1, 2);
  EXPECT_EQ(sample_problem(arm(), sample), "a target has 3 coordinates, not 2");
  sample.target_mm.reset();
  sample.q.conservativeResize(5);
  EXPECT_EQ(sample_problem(arm(), sample), "there are 5 joint values for 6 joints");
}

TEST(SampleLayout, SaysJointsInWords) {
  EXPECT_EQ(
      joints_in_words(layout_of(geometry::default_rig()), Eigen::Vector2d(1.5, 0.1)),
      "joint angles (1.5, 0.1) rad");
  EXPECT_EQ(
      joints_in_words(
          make_layout({{"q1", "rad"}, {"q2", "mm"}}, {}, {"x", "y"}), Eigen::Vector2d(1.5, 20)),
      "joints (1.5 rad, 20 mm)");
}

}  // namespace
}  // namespace sixdial::session
