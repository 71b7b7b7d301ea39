// Files as people have them: decimal commas, damaged time stamps, YAML, no header, several
// files.
#include "session/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "session/bundle.h"
#include "session/csv.h"
#include "session/data_error.h"
#include "session/measured_turn.h"
#include "session/sample_layout.h"
#include "session/traceability.h"

namespace sixdial::session {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class Importing : public ::testing::Test {
 protected:
  Importing() { std::filesystem::create_directories(folder_ / "left"); }
  ~Importing() override { std::filesystem::remove_all(folder_); }
  Importing(const Importing&) = delete;
  Importing& operator=(const Importing&) = delete;

  std::string write(const std::string& name, const std::string& text) {
    const auto path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    write_file(path.string(), text);
    return path.string();
  }
  /// A rig of two axes, its instrument, and a map that names it.
  ImportMap map(const std::string& instrument, const std::string& text) {
    write(
        "rig.toml",
        "name = \"arm\"\n[robot]\nmodel = \"serial\"\n[[joint]]\nname = \"pan\"\nalpha_deg = "
        "90\n"
        "[[joint]]\na_mm = 100\n" +
            instrument);
    return read_import_map(write("map.toml", "rig = \"rig.toml\"\n" + text));
  }
  static Session session(const Imported& imported) {
    return parse_session(imported.session_csv, "session.csv", imported.rig_toml, "rig.toml");
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("sixdial_import_" + std::to_string(::getpid()));
};

constexpr const char* kPosition = "[instrument]\nkind = \"position\"\n";
constexpr const char* kColumns =
    "[[column]]\nfrom = \"Zeit\"\nto = \"time_utc\"\n"
    "[[column]]\nfrom = \"J1\"\nto = \"pan_rad\"\nunit = \"deg\"\n"
    "[[column]]\nfrom = \"J2\"\nto = \"q2_rad\"\nunit = \"deg\"\n"
    "[[column]]\nfrom = \"x\"\nto = \"x_mm\"\nunit = \"m\"\nmissing = [\"0\"]\n"
    "[[column]]\nfrom = \"y\"\nto = \"y_mm\"\nunit = \"m\"\n"
    "[[column]]\nfrom = \"z\"\nto = \"z_mm\"\nunit = \"m\"\n"
    "[[column]]\nfrom = \"sx\"\nto = \"sd_x_mm\"\n";

TEST_F(Importing, DecimalCommasAndDamagedTimesOfASpreadsheet) {
  const auto read = import_files(
      {write(
          "a.csv",
          "\xEF\xBB\xBFZeit;J1;J2;x;y;z;sx\r\n"
          "2,02011E+13;90;-45,5;0,1;0,2;0,3;0,01\r\n"
          "2,02011E+13;0;10;0;0,2;0,3;0,01\r\n"
          "2,02011E+13;90,01;-45,5;0,1001;0,2;0,3;0,02\r\n"
          "2,02011E+13;12;kaputt;0,1;0,2;0,3;0,02\r\n"
          "2,02011E+13;12;7;0,1;0,2\r\n")},
      map(kPosition, kColumns));
  const Session session = this->session(read);
  ASSERT_EQ(session.samples.size(), 3U);  // a joint is no number; a row is short
  EXPECT_EQ(read.left_out, 1U);
  const Sample& first = session.samples[0];
  EXPECT_NEAR(first.q[0], std::numbers::pi / 2, 1e-9);
  EXPECT_NEAR(first.q[1], -45.5 * std::numbers::pi / 180, 1e-9);
  EXPECT_NEAR(position_of(first, 0).value()[2], 300.0, 1e-9);
  EXPECT_FALSE(first.time_utc);
  EXPECT_NEAR(first.position_sd_mm[0].value(), 0.01, 1e-12);
  EXPECT_FALSE(position_of(session.samples[1], 0));  // 0 means that there is none
  // Joints that agree to a milliradian are one pose.
  EXPECT_EQ(session.samples[2].point, first.point);
  EXPECT_EQ(session.samples[2].repeat, 1);
  EXPECT_EQ(session.samples[2].set, first.set);
  EXPECT_NE(session.samples[1].set, first.set);
  EXPECT_THAT(read.notes, Contains(HasSubstr("are no time (damaged by a spreadsheet?)")));
  EXPECT_THAT(read.notes, Contains(HasSubstr("separator ';' and decimal comma")));
  EXPECT_THAT(read.notes, Contains(HasSubstr("byte order mark")));
  EXPECT_THAT(read.notes, Contains(HasSubstr("not 7 columns")));
  EXPECT_THAT(read.record, HasSubstr("sha256"));
}

TEST_F(Importing, RowsAreOnePoseByTheSameAnglesWhateverTheirUnit) {
  // Two and two rows differ by 0.03 degrees (0.0005 rad), the others by 0.1 (0.0017 rad).
  const std::string table =
      "a,b,x,y,z\n10,20,1,2,3\n10.03,20,1,2,3\n10.1,20,1,2,3\n10.13,20,1,2,3\n";
  const std::string rest =
      "[[column]]\nfrom = \"x\"\nto = \"x_mm\"\n[[column]]\nfrom = \"y\"\nto = \"y_mm\"\n"
      "[[column]]\nfrom = \"z\"\nto = \"z_mm\"\n";
  const auto points = [&](const std::string& first, const std::string& second) {
    const ImportMap how =
        map(kPosition, "[[column]]\nfrom = \"a\"\nunit = \"deg\"\nto = \"" + first +
                           "\"\n[[column]]\nfrom = \"b\"\nunit = \"deg\"\nto = \"" + second +
                           "\"\n" + rest);
    std::vector<int> result;
    for (const Sample& sample : session(import_files({write("a.csv", table)}, how)).samples) {
      result.push_back(sample.point);
    }
    return result;
  };
  const std::vector<int> two_and_two{0, 0, 1, 1};
  EXPECT_EQ(points("pan_rad", "q2_rad"), two_and_two);
  EXPECT_EQ(points("pan_deg", "q2_deg"), two_and_two);
  EXPECT_EQ(points("q1_deg", "q2_rad"), two_and_two);
}

TEST_F(Importing, TheRigFileGoesIntoTheBundleAsItIs) {
  const std::string instrument =
      "# measured by night\n[instrument]\nkind = \"position\"\n[thermometer]\nserial = "
      "\"T-3\"\n";
  const ImportMap how = map(instrument, kColumns);
  const std::string table = "Zeit;J1;J2;x;y;z;sx\n1600000000;90;45;1;2;3;0,1\n";
  const auto read = import_files({write("a.csv", table)}, how);
  EXPECT_EQ(read.rig_toml, read_file((folder_ / "rig.toml").string()));
  EXPECT_THAT(read.rig_toml, HasSubstr("# measured by night"));
}

TEST_F(Importing, ARigFileThatGetsSocketsKeepsWhoAndWithWhat) {
  const ImportMap how = map(
      "[instrument]\nkind = \"socket\"\nsd_mm = 0.1\n[thermometer]\nserial = \"T-3\"\ndue = "
      "2027-01-15\n",
      "[[column]]\nfrom = \"file\"\nto = \"socket\"\n"
      "[[column]]\nfrom = 1\nto = \"q1_rad\"\n[[column]]\nfrom = 2\nto = \"q2_rad\"\n");
  const auto read = import_files({write("S1.csv", "0.5,0.75\n0.6,0.7\n")}, how);
  const Traceability traced = traceability_of(read.rig_toml);
  ASSERT_NE(traced.find("thermometer"), nullptr);
  EXPECT_EQ(traced.find("thermometer")->words(), "serial T-3, due 2027-01-15");
  EXPECT_THAT(read.notes, Contains(HasSubstr("lost its comments")));
}

TEST_F(Importing, ANumberIsAPlaceWithAHeaderToo) {
  const ImportMap how =
      map(kPosition,
          "[[column]]\nfrom = 2\nto = \"q1_rad\"\n[[column]]\nfrom = 1\nto = \"q2_rad\"\n"
          "[[column]]\nfrom = \"x\"\nto = \"x_mm\"\n[[column]]\nfrom = 4\nto = \"y_mm\"\n"
          "[[column]]\nfrom = 5\nto = \"z_mm\"\n");
  const auto read =
      this->session(import_files({write("a.csv", "b,a,x,y,z\n0.2,0.1,1,2,3\n")}, how));
  ASSERT_EQ(read.samples.size(), 1U);
  EXPECT_EQ(read.samples[0].q[0], 0.1);
  EXPECT_EQ(position_of(read.samples[0], 0).value()[2], 3.0);
  try {
    static_cast<void>(import_files({write("a.csv", "b,a,x,y\n0.2,0.1,1,2\n")}, how));
    FAIL() << "there is no fifth column";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the file has 4: b, a, x, y"));
  }
}

TEST_F(Importing, YamlRecordsByTheirPaths) {
  constexpr const char* kYaml =
      "'1593701755':\n  camera_joints: []\n  pose:\n    qw: 1.0\n    qx: 0.0\n    qy: 0.0\n"
      "    qz: 0.0\n    x: -0.5\n    y: 0.25\n    z: 1\n  target_joints:\n  - 0.5\n  - 0.25\n"
      "'1593701808':\n  camera_joints: []\n  pose:\n    qw: 0.0\n    qx: 1.0\n    qy: 0.0\n"
      "    qz: 0.0\n    x: -0.6\n    y: 0.25\n    z: 1\n  target_joints:\n  - 0.75\n  - 0.25\n";
  const auto read = import_files(
      {write("m.yaml", kYaml)},
      map("[instrument]\nkind = \"pose\"\nsd_mm = 0.1\nsd_deg = 0.01\n",
          "[[column]]\nfrom = \"key\"\nto = \"time_utc\"\n"
          "[[column]]\nfrom = \"target_joints.0\"\nto = \"q1_rad\"\n"
          "[[column]]\nfrom = \"target_joints.1\"\nto = \"q2_rad\"\n"
          "[[column]]\nfrom = \"pose.x\"\nto = \"x_mm\"\nunit = \"m\"\n"
          "[[column]]\nfrom = \"pose.y\"\nto = \"y_mm\"\nunit = \"m\"\n"
          "[[column]]\nfrom = \"pose.z\"\nto = \"z_mm\"\nunit = \"m\"\n"
          "[[column]]\nfrom = \"pose.qw\"\nto = \"qw\"\n"
          "[[column]]\nfrom = \"pose.qx\"\nto = \"qx\"\n"
          "[[column]]\nfrom = \"pose.qy\"\nto = \"qy\"\n"
          "[[column]]\nfrom = \"pose.qz\"\nto = \"qz\"\n"));
  const Session session = this->session(read);
  ASSERT_EQ(session.samples.size(), 2U);
  EXPECT_TRUE(session.samples[0].time_utc);
  EXPECT_NEAR(position_of(session.samples[0], 0).value()[0], -500.0, 1e-9);
  ASSERT_EQ(session.samples[1].others.size(), 3U);
  EXPECT_NEAR(session.samples[0].others[0].value(), 0.0, 1e-12);
  EXPECT_NEAR(session.samples[1].others[0].value(), std::numbers::pi, 1e-9);
}

TEST_F(Importing, ATurnWithoutAllOfItsAnglesIsNone) {
  const auto read = import_files(
      {write(
          "poses.csv",
          "a,b,x,y,z,rx,ry,rz\n0.1,0.2,1,2,3,10,,30\n0.3,0.4,1,2,4,10,20,30\n"
          "0.5,0.6,1,2,5,,,\n0.7,0.8,1,2,6,10,20,?\n")},
      map("[instrument]\nkind = \"pose\"\n",
          "[[column]]\nfrom = \"a\"\nto = \"q1_rad\"\n[[column]]\nfrom = \"b\"\nto = "
          "\"q2_rad\"\n"
          "[[column]]\nfrom = \"x\"\nto = \"x_mm\"\n[[column]]\nfrom = \"y\"\nto = \"y_mm\"\n"
          "[[column]]\nfrom = \"z\"\nto = \"z_mm\"\n"
          "[[column]]\nfrom = \"rx\"\nto = \"rx_deg\"\n[[column]]\nfrom = \"ry\"\nto = "
          "\"ry_deg\"\n"
          "[[column]]\nfrom = \"rz\"\nto = \"rz_deg\"\n"));
  const Session session = this->session(read);
  ASSERT_EQ(session.samples.size(), 4U);
  // Two of them were there in part; a row without any angle has lost nothing.
  EXPECT_THAT(
      read.notes,
      Contains("2 measured turns are left out: not all of their numbers were read"));
  const SampleLayout layout = layout_of(session.rig);
  EXPECT_TRUE(position_of(session.samples[0], 0));
  EXPECT_FALSE(turn_of(session.samples[0], layout));
  ASSERT_TRUE(turn_of(session.samples[1], layout));
  EXPECT_NEAR((*turn_of(session.samples[1], layout))[2], std::numbers::pi / 6, 1e-9);
  // A bundle that says half a turn is mistaken.
  try {
    static_cast<void>(parse_session(
        "set,q1_rad,q2_rad,x_mm,y_mm,z_mm,rx_deg,ry_deg,rz_deg\nG1,0.1,0.2,1,2,3,10,,30\n",
        "session.csv", read.rig_toml, "rig.toml"));
    FAIL() << "two angles are no turn";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("ry_deg: is empty while its partners are not"));
  }
}

TEST_F(Importing, FilesWithoutAHeaderNameASocketEach) {
  const ImportMap how =
      map("[instrument]\nkind = \"socket\"\nsd_mm = 0.1\n",
          "[file]\nfile_parts = 2\n[sets]\nrule = \"all\"\n"
          "[sockets]\npair_distance_mm = 50\npair_sd_mm = 0.1\n"
          "[[column]]\nfrom = \"file\"\nto = \"socket\"\n"
          "[[column]]\nfrom = 1\nto = \"q1_rad\"\n[[column]]\nfrom = 2\nto = \"q2_rad\"\n");
  const auto read = import_files(
      {write("left/hole_0.csv", "1.5e+00,2.5e-01\n1.25,0.5\n"),
       write("left/hole_1.csv", "0.5,0.75\n")},
      how);
  const Session session = this->session(read);
  ASSERT_EQ(session.samples.size(), 3U);
  ASSERT_EQ(session.rig.instrument.sockets.size(), 2U);
  EXPECT_EQ(session.rig.instrument.sockets[1].name, "left_hole_1");
  ASSERT_EQ(session.rig.instrument.socket_distances.size(), 1U);
  EXPECT_EQ(session.rig.instrument.socket_distances[0].mm, 50.0);
  EXPECT_TRUE(session.samples[2].others[3]);
  EXPECT_FALSE(session.samples[2].others[0]);
  EXPECT_THAT(read.notes, Contains(HasSubstr("there is no header")));
}

TEST_F(Importing, FilesBesideEachOtherAreColumnsOfTheSameRows) {
  const ImportMap how = map(
      kPosition,
      "[file]\ntogether = \"columns\"\n"
      "[[column]]\nfrom = \"a\"\nto = \"q1_rad\"\n[[column]]\nfrom = \"b\"\nto = \"q2_rad\"\n"
      "[[column]]\nfrom = \"2:a\"\nto = \"x_mm\"\n[[column]]\nfrom = \"c\"\nto = \"y_mm\"\n"
      "[[column]]\nfrom = \"d\"\nto = \"z_mm\"\n");
  const std::string joints = write("j.txt", "a b\n0.1 0.2\n0.3 0.4\n");
  const Session session =
      this->session(import_files({joints, write("p.txt", "a\tc\td\n1\t2\t3\n4\t5\t6\n")}, how));
  ASSERT_EQ(session.samples.size(), 2U);
  EXPECT_EQ(position_of(session.samples[1], 0).value()[0], 4.0);
  EXPECT_THROW(
      (void)import_files({joints, write("p.txt", "a\tc\td\n1\t2\t3\n")}, how), DataError);
}

TEST_F(Importing, SaysWhatIsWrongWithAMap) {
  const auto error = [&](const std::string& text) {
    try {
      map(kPosition, text);
    } catch (const DataError& refused) {
      return std::string(refused.what());
    }
    return std::string("read");
  };
  EXPECT_THAT(error(""), HasSubstr("[[column]]"));
  EXPECT_THAT(error("[[column]]\nto = \"x_mm\"\n"), HasSubstr("from"));
  EXPECT_THAT(
      error("[[column]]\nfrom = \"a\"\nto = \"x_mm\"\nunit = \"deg\"\n"),
      HasSubstr("does not turn into the unit"));
  EXPECT_THAT(error("[file]\ndecimal = \"dot\"\n"), HasSubstr("\"point\" or \"comma\""));
  EXPECT_THAT(error("[sets]\nrule = \"some\"\n"), HasSubstr("none of its values"));
  EXPECT_THAT(error("[[column]]\nfrom = 0\nto = \"x_mm\"\n"), HasSubstr("has the number 1"));
  EXPECT_THAT(
      error("[[column]]\nfrom = \"a\"\nto = \"point\"\n"),
      HasSubstr("map.toml:4:6: to: 'point' cannot be given"));
  EXPECT_THAT(
      error("[[column]]\nfrom = 1\nto = \"x_mm\"\n[[column]]\nfrom = 2\nto = \"x_mm\"\n"),
      HasSubstr("two [[column]] give 'x_mm'"));
  EXPECT_THAT(error("[[column]]\nfrom = \"a\"\n"), Not(HasSubstr("rig file")));
  try {
    static_cast<void>(read_import_map(write("no_rig.toml", "[file]\nheader = true\n")));
    FAIL() << "a map needs a rig";
  } catch (const DataError& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("every map needs it"));
  }
  const ImportMap lacks = map(kPosition, "[[column]]\nfrom = \"J1\"\nto = \"pan_rad\"\n");
  EXPECT_THROW((void)import_files({write("a.csv", "J1,x\n1,2\n")}, lacks), DataError);
}

TEST_F(Importing, GuessesAFirstMapAndSaysWhy) {
  const std::string file = write(
      "g.csv",
      "joint_1;joint_2;meas_x;meas_y;meas_z;std_x;note\n"
      "90,5;-12;512,25;3,5;-4;0,01;ok\n10;20;300;2;1;0,01;ok\n");
  const std::string guessed = guessed_map({file, read_file(file)}, "rig.toml").text;
  EXPECT_THAT(guessed, HasSubstr("to = \"q1_rad\"\nunit = \"deg\""));
  EXPECT_THAT(guessed, HasSubstr("values up to 90.5 are degrees"));
  EXPECT_THAT(guessed, HasSubstr("to = \"x_mm\"\nunit = \"mm\""));
  EXPECT_THAT(guessed, HasSubstr("decimal comma"));
  EXPECT_THAT(guessed, HasSubstr("#   note"));
  map(kPosition, kColumns);  // the rig file
  const auto read = import_files({file}, read_import_map(write("guess.toml", guessed)));
  EXPECT_EQ(this->session(read).samples.size(), 2U);
}

TEST(ImportTable, IsReadFromUtf16AndWithBlanks) {
  const std::string utf16(
      "\xFF\xFE"
      "a\0;\0b\0\n\0"
      "1\0;\0"
      "2\0\n\0",
      18);
  const ImportTable table = read_table(utf16, "a.txt", {});
  ASSERT_EQ(table.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(table.rows[0][1], "2");
  EXPECT_EQ(number_in("1,5", ','), 1.5);
  EXPECT_FALSE(number_in("1.5.2", '.'));
  EXPECT_FALSE(number_in("1.000,5", ','));
  EXPECT_THROW((void)read_table("", "a.txt", {}), DataError);
  EXPECT_THROW((void)read_table("a: [", "a.yaml", {}), DataError);
  EXPECT_THROW((void)read_table("5", "a.yaml", {}), DataError);
}

}  // namespace
}  // namespace sixdial::session
