// Tables as programs write them: names of joints, units in a row, in brackets or in a name's
// ending, time stamps with a blank. Drawn tables come back as what they were made from; what a
// file does not say is told.
#include "session/import_guess.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include "geometry/units.h"
#include "tests/session/imported.h"

namespace sixdial::session {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A table drawn with what it was made from.
struct Drawn {
  std::string text;
  std::vector<std::array<double, 3>> q_rad, p_mm;
  bool units_told = false;
};

struct DrawnUnit {
  const char* name;
  double stored;  // one of it, in rad or mm
};
using geometry::kRadPerDeg;
constexpr std::array kAngles{
    DrawnUnit{"deg", kRadPerDeg}, DrawnUnit{"rad", 1.0}, DrawnUnit{"mrad", 1e-3},
    DrawnUnit{"gon", 0.9 * kRadPerDeg}};
constexpr std::array kLengths{
    DrawnUnit{"mm", 1.0}, DrawnUnit{"m", 1000.0}, DrawnUnit{"um", 1e-3}, DrawnUnit{"cm", 10.0}};

Drawn drawn_table(unsigned seed) {
  std::mt19937 random(seed);
  const auto pick = [&](auto n) {
    return std::uniform_int_distribution<std::size_t>(
        0, static_cast<std::size_t>(n) - 1)(random);
  };
  constexpr std::array kJoints{"Achse{}", "A{}", "axis {}", "J{}", "joint_{}", "Gelenk{}"};
  constexpr std::array kPlaces{"{}", "p{}", "meas {}", "Pos{}"};
  constexpr std::array kSeparators{';', ',', '\t', '|'};
  constexpr std::array kTimes{
      "2026-11-30 10:09:25.5", "2026-11-30T10:09:25.500Z", "30.11.2026 10:09:25.5"};
  Drawn drawn;
  const char separator = kSeparators[pick(kSeparators.size())];
  const bool comma = separator != ',' && pick(2) == 0;
  const std::size_t way = pick(4);  // row of units, brackets, ending, none
  drawn.units_told = way < 3;
  const DrawnUnit angle = drawn.units_told ? kAngles[pick(kAngles.size())] : kAngles[0];
  const DrawnUnit length = drawn.units_told ? kLengths[pick(kLengths.size())] : kLengths[0];
  const char* const joint = kJoints[pick(kJoints.size())];
  const char* const place = kPlaces[pick(kPlaces.size())];
  const char* const time = kTimes[pick(kTimes.size())];
  // What stands in each column: joints 0 1 2, places 3 4 5, a time, a number, a text.
  std::array<std::size_t, 9> order{0, 1, 2, 3, 4, 5, 6, 7, 8};
  std::shuffle(order.begin(), order.end(), random);
  std::string units;
  for (const std::size_t what : order) {
    const bool is_joint = what < 3;
    std::string name = is_joint   ? fmt::format(fmt::runtime(joint), what + 1)
                       : what < 6 ? fmt::format(fmt::runtime(place), "xyz"[what - 3])
                       : what < 7 ? std::string("stamp")
                       : what < 8 ? std::string("Nr")
                                  : std::string("note");
    const std::string unit = is_joint ? angle.name : what < 6 ? length.name : "";
    if (way == 0) units += unit + separator;
    if (way == 1 && !unit.empty()) name += " [" + unit + "]";
    if (way == 2 && !unit.empty()) name += "_" + unit;
    drawn.text += name + separator;
  }
  drawn.text.back() = '\n';
  if (way == 0) {
    units.back() = '\n';
    drawn.text += units;
  }
  std::uniform_real_distribution<double> turn(-2.5, 2.5);
  std::uniform_real_distribution<double> far(-900.0, 900.0);
  for (int row = 0; row < 12; ++row) {
    auto& q = drawn.q_rad.emplace_back();
    auto& p = drawn.p_mm.emplace_back();
    for (double& each : q) each = turn(random);
    for (double& each : p) each = far(random);
    for (const std::size_t what : order) {
      std::string cell = what < 3   ? fmt::format("{:.9f}", q[what] / angle.stored)
                         : what < 6 ? fmt::format("{:.9f}", p[what - 3] / length.stored)
                         : what < 7 ? std::string(time)
                         : what < 8 ? std::to_string(row)
                                    : std::string("fine");
      if (comma && what < 6) std::ranges::replace(cell, '.', ',');
      drawn.text += cell + separator;
    }
    drawn.text.back() = '\n';
  }
  return drawn;
}

TEST(ImportGuess, DrawnTablesComeBackAsWhatTheyWereMadeFrom) {
  constexpr double kDigits = 2e-6;  // nine digits behind the point of a metre, of a milliradian
  int told = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    const Drawn drawn = drawn_table(seed);
    SCOPED_TRACE(fmt::format("seed {}: {}", seed, drawn.text.substr(0, 400)));
    const Taken all = taken(drawn.text);
    ASSERT_EQ(all.session.samples.size(), drawn.q_rad.size());
    ASSERT_EQ(all.imported.left_out, 0U);
    for (std::size_t i = 0; i < drawn.q_rad.size(); ++i) {
      const Sample& sample = all.session.samples[i];
      const auto position = position_of(sample, 0).value();
      for (std::size_t k = 0; k < 3; ++k) {
        const auto index = static_cast<Eigen::Index>(k);
        ASSERT_NEAR(sample.q[index], drawn.q_rad[i][k], kDigits);
        ASSERT_NEAR(position[index], drawn.p_mm[i][k], kDigits);
      }
      ASSERT_EQ(to_iso8601(sample.time_utc.value()), "2026-11-30T10:09:25.500Z");
    }
    told += drawn.units_told ? 1 : 0;
    EXPECT_THAT(all.map.open, Not(Contains(HasSubstr("no unit is in the file"))));
  }
  EXPECT_GT(told, 80);
}

TEST(ImportGuess, ARowOfUnitsIsToldAndIsNoDamagedRow) {
  const Taken all = taken(
      "Nr;Achse1;Achse2;Achse3;X;Y;Z\n;deg;deg;deg;m;m;m\n1;90;45;10;0,5;0,6;0,7\n"
      "2;80;40;20;0,4;0,5;0,6\n");
  EXPECT_EQ(all.session.samples.size(), 2U);
  EXPECT_EQ(all.imported.left_out, 0U);
  EXPECT_THAT(
      all.imported.notes,
      Contains(HasSubstr("line 2 is a row of units (deg, deg, deg, m, m, m), not of values")));
  EXPECT_THAT(all.imported.notes, Not(Contains(HasSubstr("no number"))));
}

TEST(ImportTable, ARowOfTextIsNoRowOfUnits) {
  // A first row of values whose texts could be units, a row with no length and no angle.
  for (const char* second : {"1,deg,2", "a,b,c", "s,N,V", "12,,", ",,"}) {
    const ImportTable table =
        read_table(fmt::format("q1,q2,x\n{}\n1,2,3\n", second), "a.csv", {});
    EXPECT_THAT(table.units, IsEmpty()) << second;
    EXPECT_EQ(table.rows.size(), 2U) << second;
  }
  const ImportTable told = read_table("q1,q2,x\na,b,c\n1,2,3\n", "a.csv", {.units_row = true});
  EXPECT_EQ(told.rows.size(), 1U);
  const ImportTable refused =
      read_table("q1,q2,x\ndeg,deg,mm\n1,2,3\n", "a.csv", {.units_row = false});
  EXPECT_EQ(refused.rows.size(), 2U);
}

TEST(ImportTable, AnEmptyCellAtTheEndOfALineIsACell) {
  const ImportTable table = read_table("a\tb\tc\n\t2\t3\n1\t2\t\n1\t2\t3\t\r\n", "a.txt", {});
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"", "2", "3"}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"1", "2", ""}));
  // A header that ends with a separator has one name less than it seems.
  EXPECT_EQ(read_table("a\tb\t\n1\t2\n3\t4\t\n", "a.txt", {}).rows.size(), 2U);
}

TEST(ImportGuess, SaysWhatTheFileLeavesOpen) {
  const auto open = [](const std::string& table, const char* rig = kArm) {
    const SampleLayout layout = layout_of_text(rig);
    return guessed_map({"a.csv", table}, "rig.toml", &layout).open;
  };
  // 0.5 may be radians, or degrees of a small move; so 0.3 metres, or millimetres.
  const std::string small = "J1,J2,J3,x,y,z\n0.5,0.4,0.3,0.1,0.2,0.3\n";
  EXPECT_THAT(
      open(small),
      AllOf(
          Contains(HasSubstr("joint values up to 0.5: no unit is in the file; they "
                             "are taken as radians")),
          Contains(HasSubstr("places up to 0.3: no unit is in the file"))));
  EXPECT_THAT(
      open("J1 [deg],J2 [deg],J3 [deg],x [mm],y [mm],z [mm]\n0.5,0.4,0.3,0.1,0.2,0.3\n"),
      IsEmpty());
  // One file, one unit: a joint that hardly moved is in degrees as the others are.
  const Taken one = taken("J1,J2,J3,x,y,z\n90,2,-40,100,200,300\n");
  EXPECT_NEAR(one.session.samples[0].q[1], 2.0 * kRadPerDeg, 1e-9);
  EXPECT_THAT(
      open("J1 [deg],J2 [deg],A1 [deg],x [mm],y [mm],z [mm]\n1,2,3,4,5,6\n"),
      AllOf(
          Contains(HasSubstr("'J1 [deg]' and 'A1 [deg]' may both be joint 1")),
          Contains(HasSubstr("no column was recognised for q3_rad"))));
  EXPECT_THAT(
      open("J1,J2,J3,tcp_x,meas_x\n50,2,3,400,500\n"),
      AllOf(
          Contains(HasSubstr("'meas_x' and 'tcp_x' may both be x")),
          Contains(HasSubstr("y_mm, z_mm"))));
  EXPECT_THAT(
      open("J1 [grad],J2,J3,x,y,z\n50,2,3,400,500,600\n"),
      Contains(HasSubstr("'grad' is the degree in German and gon elsewhere")));
  EXPECT_THAT(
      open("J1 [rad],J2 [rad],J3 [rad],x,y,z\n50,2,3,400,500,600\n"),
      Contains(HasSubstr("values up to 50 are many turns: are they degrees?")));
  EXPECT_THAT(
      open("J1 [deg],J2 [deg],J3 [deg],x_mm,y,z\ndeg,deg,deg,m,m,m\n50,2,3,400,500,600\n"),
      Contains(HasSubstr("its name says mm, the row of units m: m is taken")));
  EXPECT_THAT(
      open("joint_0,joint_1,joint_2,x,y,z\n50,2,3,400,500,600\n"),
      Contains(HasSubstr("counted from 0: 'joint_0' is joint 1")));
  EXPECT_THAT(
      open("cmd J1,cmd J2,cmd J3,x,y,z\n50,2,3,400,500,600\n"),
      Contains(HasSubstr("only commanded values")));
  EXPECT_THAT(
      open("pan_joint,lift_joint,elbow_joint,x,y,z\n50,2,3,400,500,600\n"),
      Contains(HasSubstr("taken in the order of the file")));
  EXPECT_THAT(
      open("pan_joint,lift_joint,x,y,z\n50,2,400,500,600\n"),
      Contains(HasSubstr("2 columns speak of joints without numbering them, the rig has 3")));
}

TEST(ImportGuess, KnowsTheRigsJoints) {
  // The first joint slides: millimetres, and no degrees.
  const Taken slide = taken("q1,q2,q3,x,y,z\n250,90,45,1,2,300\n", kGantry);
  EXPECT_NEAR(slide.session.samples[0].q[0], 250.0, 1e-9);
  EXPECT_NEAR(slide.session.samples[0].q[1], 90.0 * kRadPerDeg, 1e-8);
  const SampleLayout gantry = layout_of_text(kGantry);
  const FirstMap wrong =
      guessed_map({"a.csv", "q1_deg,q2,q3,x,y,z\n250,90,45,1,2,300\n"}, "", &gantry);
  EXPECT_THAT(
      wrong.text, HasSubstr("q1_deg (1 numbers from 250 to 250): its name says deg, "
                            "but joint 1 of the rig slides"));
  EXPECT_THAT(wrong.open, Contains(HasSubstr("no column was recognised for q1_mm")));
  // Read back and commanded, both; an axis that the rig does not have.
  const Taken both =
      taken("A1,A2,A3,A4,Soll A1,Soll A2,Soll A3,x,y,z\n90,45,10,3,91,46,11,100,200,300\n");
  EXPECT_THAT(both.map.text, HasSubstr("the rig has 3 joints"));
  ASSERT_EQ(both.session.samples[0].q_command.size(), 3);
  EXPECT_NEAR(both.session.samples[0].q_command[0], 91.0 * kRadPerDeg, 1e-8);
}

TEST(ImportGuess, SaysWhyATimeIsNone) {
  const auto text = [](const std::string& table) {
    return guessed_map({"a.csv", table}, "").text;
  };
  EXPECT_THAT(
      text("time;J1\n03/04/2026 10:09;1\n"), HasSubstr("day and month cannot be told apart"));
  EXPECT_THAT(text("time;J1\n10:09:25;1\n"), HasSubstr("a time needs both in one column"));
  EXPECT_THAT(text("time;J1\n12.5;1\n"), HasSubstr("numbers that are no seconds since 1970"));
}

TEST(ImportGuess, OfTwoColumnsOfTimesTheNamedOneCountsAndTheOtherIsTold) {
  const SampleLayout layout = layout_of_text(kArm);
  const std::string row = "2026-11-29T08:00:00Z,0.5,0.4,0.3,100,200,300,2026-11-30T09:00:00Z\n";
  const FirstMap map =
      guessed_map({"a.csv", "created,J1,J2,J3,x,y,z,timestamp\n" + row}, "rig.toml", &layout);
  EXPECT_THAT(map.text, HasSubstr("from = \"timestamp\"\nto = \"time_utc\""));
  EXPECT_THAT(map.open, Contains(HasSubstr("column 'created' has times too")));
}

TEST(ImportTable, BlanksThatSeparateColumnsAreToldAndATimeStampIsOneColumn) {
  const Taken all = taken(
      "stamp J1 J2 J3 x y z\n2026-11-30 10:09:25.5 90 45 10 100 200 300\n"
      "2026-11-30 10:09:26.5 80 40 20 110 210 310\n");
  ASSERT_EQ(all.session.samples.size(), 2U);
  EXPECT_EQ(to_iso8601(all.session.samples[1].time_utc.value()), "2026-11-30T10:09:26.500Z");
  EXPECT_THAT(all.imported.notes, Contains(HasSubstr("separator ' ' (blanks)")));
  EXPECT_THAT(
      all.imported.notes, Contains(HasSubstr("blanks separate the columns: date and time of 2 "
                                             "rows were taken for one column")));
}

}  // namespace
}  // namespace sixdial::session
