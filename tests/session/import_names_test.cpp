// What names of columns, units and time stamps say, one spelling a case.
#include "session/import_names.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "session/import_guess.h"
#include "session/import_time.h"
#include "session/import_units.h"
#include "tests/session/imported.h"

namespace sixdial::session {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class JointNames : public ::testing::TestWithParam<const char*> {};

TEST_P(JointNames, AreJointsInTheirOrder) {
  // "%" is the joint's number; the columns stand in the wrong order.
  const auto name = [](int joint) {
    std::string text = GetParam();
    return text.replace(text.find('%'), 1, std::to_string(joint));
  };
  const std::string table = fmt::format("{};{};{};x;y;z\n", name(3), name(1), name(2)) +
                            "-30.5;10.5;90;100;200;300\n31;11;-91;101;201;301\n";
  const Taken all = taken(table);
  ASSERT_EQ(all.session.samples.size(), 2U);
  const Sample& first = all.session.samples[0];
  const double deg = std::numbers::pi / 180.0;
  EXPECT_NEAR(first.q[0], 10.5 * deg, 1e-8);
  EXPECT_NEAR(first.q[1], 90.0 * deg, 1e-8);
  EXPECT_NEAR(first.q[2], -30.5 * deg, 1e-8);
  EXPECT_THAT(all.map.open, IsEmpty());
  // Without the rig, too.
  const FirstMap alone = guessed_map({"a.csv", table}, "");
  for (const char* joint : {"q1_rad", "q2_rad", "q3_rad"}) {
    EXPECT_THAT(alone.text, HasSubstr(fmt::format("to = \"{}\"\nunit = \"deg\"", joint)));
  }
}

INSTANTIATE_TEST_SUITE_P(
    , JointNames,
    ::testing::Values(
        "Achse%", "Achse %", "A%", "axis %", "Axis_%", "J%", "j%", "joint_%", "Joint %",
        "joint%_pos", "Gelenk%", "Gelenk %", "q%", "theta%", "Theta_%", "J% (deg)", "J%[deg]",
        "A% [\u00B0]", "q%_deg", "Achse % / deg", "joint % in deg", "ActJoint%", "Ist A%",
        "robot1_joint_%", "axis.%", "JOINT-%", "%. Achse", "angle %"));

TEST(ImportNames, OfSomethingElseAreNoJoints) {
  for (const char* name :
       {"J1 torque", "joint_1_velocity", "std_J1", "Temp J1", "A1 current", "dial_A", "ABC1",
        "note 1", "angle", "1", "", "[mm]", "x_P2_mm", "J100"}) {
    EXPECT_NE(role_of(name).what, NameRole::What::kJoint) << name;
  }
  EXPECT_TRUE(role_of("q1_command_rad").commanded);
  EXPECT_TRUE(role_of("Soll Achse 3").commanded);
  EXPECT_EQ(role_of("wrist_2_joint").number, 2);
  EXPECT_EQ(role_of("q_w").what, NameRole::What::kQuaternion);
}

struct PlaceHeader {
  const char* name;  // "%" is x, y or z
  double mm;         // one of it
};
class PlaceHeaders : public ::testing::TestWithParam<PlaceHeader> {};

TEST_P(PlaceHeaders, SayWhatAndInWhichUnit) {
  std::string header;
  for (const char* axis : {"x", "y", "z"}) {
    std::string text = GetParam().name;
    header += '\t' + text.replace(text.find('%'), 1, axis);
  }
  const Taken all =
      taken("J1 [deg]\tJ2 [deg]\tJ3 [deg]" + header + "\n10\t20\t30\t1.5\t-2.5\t3.5\n");
  EXPECT_THAT(all.map.open, IsEmpty());
  const auto position = position_of(all.session.samples.at(0), 0).value();
  EXPECT_NEAR(position[0], 1.5 * GetParam().mm, 1e-6);
  EXPECT_NEAR(position[1], -2.5 * GetParam().mm, 1e-6);
  EXPECT_NEAR(position[2], 3.5 * GetParam().mm, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    , PlaceHeaders,
    ::testing::Values(
        PlaceHeader{"p% [mm]", 1.0}, PlaceHeader{"% (mm)", 1.0}, PlaceHeader{"%_mm", 1.0},
        PlaceHeader{"%[m]", 1000.0}, PlaceHeader{"meas_%_m", 1000.0},
        PlaceHeader{"Pos% / cm", 10.0}, PlaceHeader{"TCP % [\u00B5m]", 1e-3},
        PlaceHeader{"% in mm", 1.0}, PlaceHeader{"% [inch]", 25.4},
        PlaceHeader{"tracker % {Metres}", 1000.0}, PlaceHeader{"%.mm", 1.0}));

struct Stamp {
  const char* cell;
  const char* utc;  // empty: no time
  bool zone_assumed;
};
class Stamps : public ::testing::TestWithParam<Stamp> {};

TEST_P(Stamps, AreTimesInUtc) {
  const auto time = time_in(GetParam().cell, '.');
  ASSERT_EQ(time.has_value(), *GetParam().utc != '\0');
  if (!time) return;
  EXPECT_EQ(time->utc, GetParam().utc);
  EXPECT_EQ(time->zone_assumed, GetParam().zone_assumed);
}

INSTANTIATE_TEST_SUITE_P(
    , Stamps,
    ::testing::Values(
        Stamp{"2026-11-30 10:09:25.5", "2026-11-30T10:09:25.500Z", true},
        Stamp{"2026-11-30 10:09:25,25", "2026-11-30T10:09:25.250Z", true},
        Stamp{"2026-11-30T10:09:25Z", "2026-11-30T10:09:25Z", false},
        Stamp{"2026-11-30 10:09:25Z", "2026-11-30T10:09:25.000Z", false},
        Stamp{"2026-11-30T10:09:25.123456789", "2026-11-30T10:09:25.123Z", true},
        Stamp{"2026-11-30 00:30:00+01:00", "2026-11-29T23:30:00.000Z", false},
        Stamp{"2026-11-30 10:09:25 -0530", "2026-11-30T15:39:25.000Z", false},
        Stamp{"2026/11/30 10:09", "2026-11-30T10:09:00.000Z", true},
        Stamp{"30.11.2026 10:09:25", "2026-11-30T10:09:25.000Z", true},
        Stamp{"30.11.2026, 10:09:25", "2026-11-30T10:09:25.000Z", true},
        Stamp{"20261130100925", "2026-11-30T10:09:25.000Z", true},
        Stamp{"1600000000", "2020-09-13T12:26:40.000Z", false},
        Stamp{"03/04/2026 10:09:25", "", false}, Stamp{"2026-11-30", "", false},
        Stamp{"10:09:25", "", false}, Stamp{"2026-02-30 10:09:25", "", false},
        Stamp{"2026-11/30 10:09:25", "", false}, Stamp{"2026-11-30 24:09:25", "", false},
        Stamp{"0000-01-01 00:00:00+23:00", "", false}, Stamp{"2,02011E+13", "", false},
        Stamp{"", "", false}));

TEST(ImportUnits, AreKnownByTheirSpellings) {
  for (const char* text : {"deg", "Degrees", "[\u00B0]", "(DEG)"}) {
    ASSERT_NE(find_import_unit(text), nullptr) << text;
    EXPECT_EQ(find_import_unit(text)->name, "deg") << text;
  }
  for (const char* text : {"", "[]", "grads", "mmm", "tool"}) {
    EXPECT_EQ(find_import_unit(text), nullptr) << text;
  }
  const Taken kelvin = taken("J1,J2,J3,x,y,z,temp [K]\n90,2,3,400,500,600,293.65\n");
  EXPECT_NEAR(kelvin.session.samples[0].temperature_c.value(), 20.5, 1e-9);
}

}  // namespace
}  // namespace sixdial::session
