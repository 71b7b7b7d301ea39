// Units of another kind, unknown ones, files side by side that do not agree: nothing of it
// passes in silence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "geometry/units.h"
#include "session/bundle.h"
#include "session/data_error.h"
#include "session/import.h"
#include "session/import_guess.h"
#include "tests/session/imported.h"

namespace sixdial::session {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using geometry::kRadPerDeg;

constexpr const char* kSideBySide =
    "rig = \"rig.toml\"\n[file]\ntogether = \"columns\"\n"
    "[[column]]\nfrom = \"J1\"\nto = \"q1_rad\"\n[[column]]\nfrom = \"J2\"\nto = \"q2_rad\"\n"
    "[[column]]\nfrom = \"J3\"\nto = \"q3_rad\"\n[[column]]\nfrom = \"x\"\nto = \"x_mm\"\n"
    "[[column]]\nfrom = \"y\"\nto = \"y_mm\"\n[[column]]\nfrom = \"z\"\nto = \"z_mm\"\n";

Sample beside_each_other(const std::string& joints, const std::string& places) {
  const Imported read =
      import_texts({{"j.csv", joints}, {"p.csv", places}}, map_of(kSideBySide, kArm));
  return parse_session(read.session_csv, "session.csv", read.rig_toml, "rig.toml")
      .samples.at(0);
}

TEST(ImportSideBySide, EachFileKeepsItsUnitsAndItsDecimalMark) {
  const Sample first = beside_each_other("J1,J2,J3\ndeg,deg,deg\n90,2,3\n", "x,y,z\n4,5,6\n");
  EXPECT_NEAR(first.q[0], 90.0 * kRadPerDeg, 1e-9);
  EXPECT_NEAR(position_of(first, 0).value()[0], 4.0, 1e-9);
  const Sample second =
      beside_each_other("J1,J2,J3\n0.1,0.2,0.3\n", "x,y,z\nm,m,m\n0.4,0.5,0.6\n");
  EXPECT_NEAR(second.q[0], 0.1, 1e-9);
  EXPECT_NEAR(position_of(second, 0).value()[2], 600.0, 1e-9);
  const Sample marks = beside_each_other("J1,J2,J3\n0.1,0.2,0.3\n", "x;y;z\n4,25;5,5;6,75\n");
  EXPECT_NEAR(marks.q[2], 0.3, 1e-9);
  EXPECT_NEAR(position_of(marks, 0).value()[2], 6.75, 1e-9);
  const Sample turned = beside_each_other("J1;J2;J3\n0,1;0,2;0,3\n", "x,y,z\n4.25,5.5,6.75\n");
  EXPECT_NEAR(turned.q[2], 0.3, 1e-9);
  EXPECT_NEAR(position_of(turned, 0).value()[2], 6.75, 1e-9);
}

TEST(ImportTable, RecordsWithoutValuesAreNoTable) {
  for (const char* yaml : {"- ~\n", "- {}\n- {}\n"}) {
    try {
      static_cast<void>(import_texts(
          {{"a.yaml", yaml}},
          map_of("rig = \"rig.toml\"\n[[column]]\nfrom = \"J1\"\nto = \"q1_rad\"\n", kArm)));
      FAIL() << "there is no column";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), HasSubstr("the records of the YAML hold no values")) << yaml;
    }
  }
}

FirstMap guess_of(const std::string& table, const char* rig = kArm) {
  const SampleLayout layout = layout_of_text(rig);
  return guessed_map({"a.csv", table}, "rig.toml", &layout);
}

TEST(ImportKinds, AColumnInAUnitOfNoAngleAndNoLengthIsLeftOut) {
  const FirstMap counts = guess_of(
      "J1 [counts],J2 [deg/s],J3 [Nm],x [mm/s],y [Nm],temp [mm],z\n"
      "81920,50,3,400,500,20,600\n");
  for (const char* why :
       {"its name says counts, which is no unit of a joint",
        "its name says deg/s, which is no unit of a joint",
        "its name says Nm, which is no unit of a joint",
        "its name says mm/s, which is no unit of x", "its name says Nm, which is no unit of y",
        "its name says mm, which is no unit of a temperature"}) {
    EXPECT_THAT(counts.text, HasSubstr(why));
  }
  EXPECT_THAT(
      counts.open,
      AllOf(Contains(HasSubstr("q1_rad, q2_rad, q3_rad")), Contains(HasSubstr("x_mm, y_mm"))));
  const FirstMap row = guess_of("J1,J2,J3,x,y,z\ninc,deg,deg,mm,mm,mm\n8000,2,3,4,5,6\n");
  EXPECT_THAT(row.text, HasSubstr("the row of units says inc, which is no unit of a joint"));
  // What is left out does not stand in the way of the joint itself.
  const Taken both = taken(
      "J1 [Nm],J1 [deg],J2 [deg],J3 [deg],x [deg],x [mm],y [mm],z [mm]\n"
      "7,10,20,30,9,100,200,300\n");
  EXPECT_NEAR(both.session.samples.at(0).q[0], 10.0 * kRadPerDeg, 1e-9);
  EXPECT_NEAR(position_of(both.session.samples[0], 0).value()[0], 100.0, 1e-9);
  EXPECT_THAT(both.map.open, IsEmpty());
  // An index is no unit.
  EXPECT_NEAR(
      taken("q[1],q[2],q[3],x,y,z\n10,20,30,100,200,300\n").session.samples.at(0).q[0],
      10.0 * kRadPerDeg, 1e-9);
}

TEST(ImportKinds, AChannelOfTheRigInAnotherUnitIsLeftOut) {
  const std::string wire = std::string(kArm).substr(0, std::string(kArm).find("[instrument]")) +
                           "[instrument]\nkind = \"distance\"\nsd_mm = 0.05\n[[anchor]]\n"
                           "name = \"K1\"\nat_mm = [1000.0, 0.0, 0.0]\n";
  const FirstMap volts = guess_of("J1,J2,J3,distance_K1 [V]\n90,2,3,4\n", wire.c_str());
  EXPECT_THAT(volts.text, HasSubstr("its name says V, which is no unit of distance_K1_mm"));
  EXPECT_THAT(volts.open, Contains(HasSubstr("distance_K1_mm")));
  const FirstMap metres = guess_of("J1,J2,J3,distance_K1 [m]\n90,2,3,4\n", wire.c_str());
  EXPECT_THAT(metres.text, HasSubstr("to = \"distance_K1_mm\"\nunit = \"m\""));
  EXPECT_THAT(metres.open, Not(Contains(HasSubstr("distance_K1"))));
  const FirstMap silent = guess_of("J1,J2,J3,distance_K1\n90,2,3,4\n", wire.c_str());
  EXPECT_THAT(silent.open, Contains(HasSubstr("column 'distance_K1': no unit is in the file")));
}

TEST(ImportKinds, AUnitThatIsNotKnownIsALook) {
  const std::string rest = ",J2,J3,y,z\n50,400,20,30,500,600\n";
  for (const char* first :
       {"J1,x [ft]", "J1,x [mil]", "J1,x_in", "J1,x in", "Achse1 [arcmin],x",
        "Achse1_counts,x"}) {
    EXPECT_THAT(
        guess_of(first + rest).open,
        Contains(HasSubstr("which may be a unit and is not used: write unit, or factor")))
        << first;
  }
  for (const char* first :
       {"J1,x (TCP)", "J1 (act),x", "J(1),x [tracker]", "J1,x_inches", "J1 [-],x",
        "axis/1,x"}) {
    EXPECT_THAT(guess_of(first + rest).open, IsEmpty()) << first;
  }
  EXPECT_THAT(
      guess_of("J1,J2,J3,x,y,z\ndeg,deg,deg,mm,mm,ell\n50,2,3,4,5,6\n").open,
      Contains(HasSubstr("the row of units says ell, which is no unit that is known: write")));
  EXPECT_NEAR(
      taken("J1,J2,J3,x,y,z,temp [F]\n90,2,3,400,500,600,68\n")
          .session.samples.at(0)
          .temperature_c.value(),
      20.0, 1e-9);
  EXPECT_THAT(
      guess_of("J1,J2,J3,x,y,z,Temp_K\n90,2,3,400,500,600,293\n").open,
      Contains(HasSubstr("its name ends with K, which may be a unit")));
}

TEST(ImportKinds, AnEndingInMWithManyOfThemIsALook) {
  EXPECT_THAT(
      guess_of("J1,J2,J3,x_m,y_m,z_m\n90,2,3,512.3,100,200\n").open,
      Contains(HasSubstr("'x_m': its name says m, but values up to 512.3 are far for metres")));
  EXPECT_THAT(guess_of("J1,J2,J3,x_m,y_m,z_m\n90,2,3,0.5,0.1,0.2\n").open, IsEmpty());
  EXPECT_THAT(guess_of("J1,J2,J3,x [m],y [m],z [m]\n90,2,3,30,1,2\n").open, IsEmpty());
}

TEST(ImportKinds, CommandsOfSomeJointsOnlyAreLeftOut) {
  const Taken some = taken("J1,J2,J3,cmd J1,cmd J2,x,y,z\n90,2,3,91,3,400,500,600\n");
  EXPECT_EQ(some.session.samples.at(0).q_command.size(), 0);
  EXPECT_THAT(some.map.text, HasSubstr("commands of 2 of 3 joints"));
  const Taken unit =
      taken("J1,J2,J3,cmd J1,cmd J2,cmd J3 [Nm],x,y,z\n90,2,3,91,3,4,400,500,600\n");
  EXPECT_EQ(unit.session.samples.at(0).q_command.size(), 0);
  const FirstMap alone =
      guessed_map({"a.csv", "J1,J2,J3,cmd J1,cmd J2,x\n90,2,3,91,4,400\n"}, "");
  EXPECT_THAT(alone.text, Not(HasSubstr("command_rad")));
}

TEST(ImportKinds, AQuaternionOfRosIsNoThreeAngles) {
  const std::string pose = std::string(kArm).substr(0, std::string(kArm).find("[instrument]")) +
                           "[instrument]\nkind = \"pose\"\n";
  for (const char* stem : {"pose.orientation.", "rot_", "orientation ", "r_"}) {
    const std::string s(stem);
    const FirstMap map = guess_of(
        "J1,J2,J3,pose.position.x,pose.position.y,pose.position.z," + s + "x," + s + "y," + s +
            "z," + s + "w\n90,2,3,400,500,600,0,0,0.6,0.8\n",
        pose.c_str());
    EXPECT_THAT(
        map.text, AllOf(
                      HasSubstr("from = \"" + s + "w\"\nto = \"qw\""),
                      HasSubstr("from = \"" + s + "z\"\nto = \"qz\""), Not(HasSubstr("rx_"))));
  }
  // Without w, and with that of another turn, they stay angles.
  const std::string angles = guess_of(
                                 "J1,J2,J3,x,y,z,rot_x,rot_y,rot_z,ori_w\n"
                                 "90,2,3,400,500,600,10,20,30,1\n",
                                 pose.c_str())
                                 .text;
  EXPECT_THAT(angles, HasSubstr("from = \"rot_x\"\nto = \"rx_deg\""));
}

std::string scaled(
    const std::string& from, const std::string& to, const std::string& more = "") {
  return "[[column]]\nfrom = \"" + from + "\"\nto = \"" + to + "\"\n" + more;
}

Imported with_first(
    const std::string& header, const std::string& cell, const std::string& first) {
  return import_texts(
      {{"a.csv", header + ",b,c,y,z,d\n" + cell + ",0.2,0.3,5,6,7\n"}},
      map_of(
          "rig = \"rig.toml\"\n" + first + scaled("b", "q2_rad") + scaled("c", "q3_rad") +
              scaled("y", "y_mm") + scaled("z", "z_mm") +
              (first.find("q1_") == std::string::npos ? scaled("d", "q1_rad")
                                                      : scaled("d", "x_mm")),
          kArm));
}

TEST(ImportKinds, WhatAMapCannotTurnIsSaid) {
  const auto notes = [](const std::string& header, const std::string& first) {
    return with_first(header, "1", first).notes;
  };
  EXPECT_THAT(
      notes("J1 [deg]", scaled("J1 [deg]", "x_mm")),
      Contains(HasSubstr("column J1 [deg]: its name says deg, which does not turn into x_mm")));
  EXPECT_THAT(
      notes("J1 [Nm]", scaled("J1 [Nm]", "q1_rad")),
      Contains(HasSubstr("its name says Nm, which does not turn into q1_rad")));
  EXPECT_THAT(
      notes("J1 [grad]", scaled("J1 [grad]", "q1_rad")),
      Contains(HasSubstr("'grad' is the degree in German")));
  EXPECT_THAT(
      notes("x [ft]", scaled("x [ft]", "x_mm")),
      Contains(
          HasSubstr("ends with ft, which may be a unit and is not used: it is read in mm")));
  // The map's own unit counts; its factor needs no word.
  EXPECT_THAT(
      notes("J1 [Nm]", scaled("J1 [Nm]", "q1_rad", "unit = \"deg\"\n")),
      Contains(HasSubstr("its name says Nm, the map deg: the map counts")));
  for (const char* more : {"unit = \"deg\"\nfactor = -1\n", "factor = -0.01\n"}) {
    EXPECT_THAT(
        notes("J1 [deg]", scaled("J1 [deg]", "q1_rad", more)),
        Not(Contains(HasSubstr("column J1 [deg]"))))
        << more;
  }
  EXPECT_THAT(
      notes("J1 [rad]", scaled("J1 [rad]", "q1_rad", "unit = \"deg\"\nfactor = -1\n")),
      Contains(HasSubstr("its name says rad, the map deg: the map counts")));
}

TEST(ImportKinds, TemperaturesAreTurnedAsTheFileSays) {
  const auto read = [](const std::string& name, const std::string& cell) {
    const Imported all = import_texts(
        {{"a.csv", "a,b,c,x,y,z," + name + "\n0.1,0.2,0.3,4,5,6," + cell + "\n"}},
        map_of(
            "rig = \"rig.toml\"\n" + scaled("a", "q1_rad") + scaled("b", "q2_rad") +
                scaled("c", "q3_rad") + scaled("x", "x_mm") + scaled("y", "y_mm") +
                scaled("z", "z_mm") + scaled(name, "temperature_c"),
            kArm));
    EXPECT_THAT(all.notes, Contains(HasSubstr("turned into c"))) << name;
    return parse_session(all.session_csv, "session.csv", all.rig_toml, "rig.toml")
        .samples.at(0)
        .temperature_c.value();
  };
  EXPECT_NEAR(read("temp [K]", "293.65"), 20.5, 1e-9);
  EXPECT_NEAR(read("temp (degF)", "68"), 20.0, 1e-9);
}

}  // namespace
}  // namespace sixdial::session
