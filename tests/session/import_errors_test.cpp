// What an import says where a map lacks something, where no row is left, and where the file
// states other units than the map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "session/data_error.h"
#include "session/import.h"
#include "tests/session/imported.h"

namespace sixdial::session {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::string error_of(const std::string& table, const std::string& map) {
  try {
    static_cast<void>(
        import_texts({{"a.csv", table}}, map_of("rig = \"rig.toml\"\n" + map, kArm)));
  } catch (const DataError& error) {
    return error.what();
  }
  return "read";
}

constexpr const char* kJointsMapped =
    "[[column]]\nfrom = \"J1\"\nto = \"q1_deg\"\n[[column]]\nfrom = \"J2\"\nto = \"q2_deg\"\n"
    "[[column]]\nfrom = \"J3\"\nto = \"q3_deg\"\n";
constexpr const char* kPlacesMapped =
    "[[column]]\nfrom = \"px [m]\"\nto = \"x_mm\"\n[[column]]\nfrom = \"py [m]\"\nto = "
    "\"y_mm\"\n[[column]]\nfrom = \"pz [m]\"\nto = \"z_mm\"\n";

TEST(ImportErrors, SayWhatIsThereWhatIsMissingAndTheLinesThatWouldHelp) {
  const std::string table = "id,J1,J2,J3,px [mm],py [mm],pz [mm]\n1,10,20,30,1,2,3\n";
  const std::string no_place = error_of(table, kJointsMapped);
  EXPECT_THAT(
      no_place,
      AllOf(
          HasSubstr("the map gives nothing that was measured; this rig's instrument "
                    "measures x_mm, y_mm, z_mm"),
          HasSubstr("a.csv has 7 columns: id, J1, J2, J3, px [mm], py [mm], pz [mm]"),
          HasSubstr("[[column]]\nfrom = \"px [mm]\"\nto = \"x_mm\"\nunit = \"mm\"\n")));
  const std::string no_joint =
      error_of(table, "[[column]]\nfrom = \"px [mm]\"\nto = \"x_mm\"\n");
  EXPECT_THAT(
      no_joint, AllOf(
                    HasSubstr("no [[column]] gives 3 of the 3 joints: q1_rad, q2_rad, q3_rad"),
                    HasSubstr("a.csv has 7 columns: id, J1"),
                    HasSubstr("[[column]]\nfrom = \"J1\"\nto = \"q1_rad\"\nunit = \"deg\"\n")));
  // Names that nothing is known of: any column that is not used yet shows how.
  EXPECT_THAT(
      error_of("a;b;c;u;v;w\n1;2;3;4;5;6\n", "[[column]]\nfrom = 1\nto = \"x_mm\"\n"),
      HasSubstr("to = \"q1_rad\"\nunit = \"deg\"\n"));
  // The lines are ones that a map can have.
  const std::size_t begin = no_place.find("[[column]]\nfrom");
  const std::string lines = no_place.substr(begin, no_place.find('(', begin) - begin);
  EXPECT_EQ(map_of("rig = \"r.toml\"\n" + lines, kArm).columns.at(0).to, "x_mm");
}

TEST(ImportErrors, SayWhyNoRowIsLeft) {
  const std::string map = std::string(kJointsMapped) + kPlacesMapped;
  const std::string header = "J1,J2,J3,px [m],py [m],pz [m]\n";
  EXPECT_THAT(
      error_of(header + "1,2,,4,5,6\n1,2,bad,4,5,6\n", map),
      AllOf(
          HasSubstr("no row is left: of 2 rows 2 have no value of a joint, 0 more nothing"),
          HasSubstr("no row has a value of q3_deg (J3)"),
          HasSubstr("column J3: 1 of 2 values are no number, such as 'bad' in line 3")));
  EXPECT_THAT(
      error_of(header + "1,2,3,,,\n", map),
      AllOf(
          HasSubstr("of 1 rows 0 have no value of a joint, 1 more nothing measured"),
          HasSubstr("x_mm (px [m]), y_mm (py [m]), z_mm (pz [m])")));
  EXPECT_THAT(error_of(header + "1,2\n", map), HasSubstr("look at separator"));
}

TEST(ImportUnits, OfTheFileHoldWhereTheMapSaysNone) {
  const auto run = [](const std::string& table, const std::string& map) {
    return import_texts({{"a.csv", table}}, map_of("rig = \"rig.toml\"\n" + map, kArm));
  };
  const std::string map = std::string(kJointsMapped) + kPlacesMapped;
  const Imported brackets = run("J1,J2,J3,px [m],py [m],pz [m]\n1,2,3,0.4,0.5,0.6\n", map);
  EXPECT_THAT(brackets.session_csv, HasSubstr(",400.0"));
  EXPECT_THAT(
      brackets.notes, Contains(HasSubstr("column px [m]: its name says m: turned into mm")));
  // What the map says counts, and the contradiction is told.
  const std::string own = std::string(kJointsMapped) +
                          "[[column]]\nfrom = \"x\"\nto = \"x_mm\"\nunit = \"mm\"\n"
                          "[[column]]\nfrom = \"y\"\nto = \"y_mm\"\nunit = \"m\"\n"
                          "[[column]]\nfrom = \"z\"\nto = \"z_mm\"\n";
  const Imported row = run("J1,J2,J3,x,y,z\nrad,deg,deg,m,m,m\n1,2,3,0.4,0.5,0.6\n", own);
  EXPECT_THAT(row.session_csv, HasSubstr("57.2957795"));  // J1 is in rad, its column in deg
  EXPECT_THAT(row.session_csv, HasSubstr(",0.400000000,500.000000000,600.000000000"));
  EXPECT_THAT(
      row.notes,
      Contains(HasSubstr("column x: the row of units says m, the map mm: the map counts")));
  EXPECT_THAT(row.notes, Not(Contains(HasSubstr("column y: the row"))));
  // An ending may be a word of its own: told, not used.
  const std::string ending = std::string(kJointsMapped) +
                             "[[column]]\nfrom = \"x_m\"\nto = \"x_mm\"\n"
                             "[[column]]\nfrom = \"y\"\nto = \"y_mm\"\n"
                             "[[column]]\nfrom = \"z\"\nto = \"z_mm\"\n";
  const Imported doubt = run("J1,J2,J3,x_m,y,z\n1,2,3,400,500,600\n", ending);
  EXPECT_THAT(doubt.session_csv, HasSubstr(",400.0"));
  EXPECT_THAT(doubt.notes, Contains(HasSubstr("if that is wrong, write unit = \"m\"")));
}

}  // namespace
}  // namespace sixdial::session
