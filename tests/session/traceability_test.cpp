// What a rig file says of serial numbers and certificates, and figures that go back into it.
#include "session/traceability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "session/data_error.h"
#include "session/rig_adopt.h"
#include "session/rig_file.h"

namespace sixdial::session {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

std::string traced_rig() {
  std::string text = write_rig(geometry::default_rig());
  text = "operator = \"A. Person\"\n" + text;
  text = replaced(text, "[robot]\n", "[robot]\nserial = \"R-7\"\n");
  text = replaced(
      text, "[cuboid]\n",
      "[cuboid]\nserial = \"Q-12\"\ncertificate = \"K 4711\"\ncertified = 2026-01-15\ndue = "
      "\"2027-01-15\"\n");
  text = replaced(text, "id = \"B\"\n", "id = \"B\"\nserial = \"12345\"\ndue = 2026-02-01\n");
  return text + "\n[thermometer]\nserial = \"T-3\"\n";
}

TEST(Traceability, IsReadFromItsKeysAndChangesNoFigure) {
  const std::string text = traced_rig();
  EXPECT_EQ(write_rig(parse_rig(text, "rig.toml")), write_rig(geometry::default_rig()));
  const Traceability found = traceability_of(text);
  EXPECT_EQ(found.operator_name, "A. Person");
  ASSERT_NE(found.find("cuboid"), nullptr);
  EXPECT_EQ(
      found.find("cuboid")->words(),
      "serial Q-12, certificate K 4711 of 2026-01-15, due 2027-01-15");
  ASSERT_NE(found.find("dial B"), nullptr);
  EXPECT_EQ(found.find("dial B")->words(), "serial 12345, due 2026-02-01");
  EXPECT_EQ(found.find("robot")->serial, "R-7");
  EXPECT_EQ(found.find("thermometer")->serial, "T-3");
  EXPECT_EQ(found.find("dial A"), nullptr);
  EXPECT_TRUE(traceability_of("no toml [").parts.empty());
}

TEST(Traceability, ADateThatIsNoneIsRefusedWithItsLine) {
  const std::string wrong = replaced(traced_rig(), "\"2027-01-15\"", "\"2027-02-30\"");
  try {
    (void)parse_rig(wrong, "rig.toml");
    FAIL() << "taken";
  } catch (const DataError& error) {
    EXPECT_EQ(error.field, "due");
    EXPECT_GT(error.line, 0);
  }
  EXPECT_TRUE(is_date("2028-02-29"));
  for (const char* text :
       {"2027-02-29", "27-01-01", "2027-1-1", "2027-13-01", "tomorrow", ""}) {
    EXPECT_FALSE(is_date(text)) << text;
  }
}

TEST(Adopt, ChangesTheValueAndKeepsCommentsAndEverythingElse) {
  const std::string before = replaced(
      write_rig(geometry::default_rig()), "[robot]\n", "# ours\n[robot]   # the red one\n");
  const std::string after = with_adopted(
      before, "rig.toml", {{.key = "l11_mm", .value = {60.0417}, .sd = 0.0011}}, "monday");
  EXPECT_THAT(after, HasSubstr("# ours\n[robot]   # the red one\n"));
  EXPECT_THAT(after, HasSubstr("l11_mm = 60.041700"));
  EXPECT_THAT(after, HasSubstr("# +- 0.002200 (k = 2), found by monday"));
  geometry::Rig expected = geometry::default_rig();
  const geometry::Rig found = parse_rig(after, "rig.toml");
  int changed = 0;
  for (Eigen::Index i = 0; i < found.robot.nominal.size(); ++i) {
    if (found.robot.nominal[i] != expected.robot.nominal[i]) ++changed;
  }
  EXPECT_EQ(changed, 1);
  expected.robot.nominal = found.robot.nominal;
  EXPECT_EQ(write_rig(found), write_rig(expected));
}

TEST(Adopt, TwiceLeavesOneNoteAndTheCommentOfThePerson) {
  std::string text = replaced(write_rig(geometry::default_rig()), "[robot]\n", "[robot]\n");
  const std::size_t at = text.find("l12_mm");
  text.insert(text.find('\n', at), "   # by the drawing");
  for (const double value : {60.1, 60.2}) {
    text =
        with_adopted(text, "rig.toml", {{.key = "l12_mm", .value = {value}, .sd = 0.01}}, "x");
  }
  EXPECT_THAT(text, HasSubstr("l12_mm = 60.200000   # by the drawing  # +- 0.020000"));
  EXPECT_THAT(text, Not(HasSubstr("60.1")));
}

/// A place of a dial is a list in the dial's own table, and its deviation a key that is added.
TEST(Adopt, WritesPlacesIntoTheTableOfTheirDial) {
  const std::string before = write_rig(geometry::default_rig());
  const std::string after = with_adopted(
      before, "rig.toml",
      {{.key = "position_mm", .value = {16.04, 23.9}, .dial = "C"},
       {.key = "position_sd_mm", .value = {0.004, 0.02}, .dial = "C"},
       {.key = "side_mm", .value = {80.003}, .table = "cuboid"}},
      "monday");
  const geometry::Rig found = parse_rig(after, "rig.toml");
  geometry::Rig expected = geometry::default_rig();
  expected.dials[2].geometry.position_mm = {16.04, 23.9};
  expected.dials[2].deviations.position_mm = Eigen::Vector2d(0.004, 0.02);
  expected.cuboid.side_mm = 80.003;
  EXPECT_EQ(write_rig(found), write_rig(expected));
}

TEST(Adopt, AddsKeysBehindALastLineWithoutAnEnd) {
  std::string before = write_rig(geometry::default_rig());
  for (std::size_t at = 0; (at = before.find("\"F\"", at)) != std::string::npos;) {
    before.replace(at, 3, "'F'");
  }
  while (before.ends_with('\n')) before.pop_back();
  const std::string after = with_adopted(
      before, "rig.toml", {{.key = "position_sd_mm", .value = {0.004, 0.02}, .dial = "F"}},
      "monday");
  EXPECT_EQ(
      parse_rig(after, "rig.toml").dials[5].deviations.position_mm,
      Eigen::Vector2d(0.004, 0.02));
}

TEST(Adopt, ATableThatCannotBeChangedIsSaid) {
  EXPECT_THROW(
      (void)with_adopted(
          "name = \"x\"\n", "rig.toml", {{.key = "l11_mm", .value = {1.0}, .sd = 0.1}}, "x"),
      DataError);
}

}  // namespace
}  // namespace sixdial::session
