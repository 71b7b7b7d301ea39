// Units of another kind, unknown ones, files side by side that do not agree: nothing of it
// passes in silence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "session/bundle.h"
#include "session/data_error.h"
#include "session/import.h"
#include "session/import_guess.h"
#include "tests/session/imported.h"

namespace sixdial::session {
namespace {

using ::testing::HasSubstr;

constexpr double kDeg = std::numbers::pi / 180.0;

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
  EXPECT_NEAR(first.q[0], 90.0 * kDeg, 1e-9);
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

}  // namespace
}  // namespace sixdial::session
