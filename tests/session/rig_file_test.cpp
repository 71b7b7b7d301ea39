#include "session/rig_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "session/csv.h"
#include "session/sha256.h"
#include "tests/session/bundle_text.h"
#include "tests/support/paths.h"

namespace sixdial::session {
namespace {

using testing::HasSubstr;

std::string shared_rig() { return read_file(test_paths::test_data() + "/sessions/00/rig.toml"); }

void expect_equal(const geometry::Rig& a, const geometry::Rig& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.robot.nominal, b.robot.nominal);
  EXPECT_EQ(a.robot.working_mode, b.robot.working_mode);
  EXPECT_EQ(a.robot.assembly, b.robot.assembly);
  EXPECT_EQ(a.robot.connection, b.robot.connection);
  EXPECT_EQ(a.cuboid.side_mm, b.cuboid.side_mm);
  EXPECT_EQ(a.cuboid.mount, b.cuboid.mount);
  EXPECT_EQ(a.cuboid.reference_pose_mm, b.cuboid.reference_pose_mm);
  ASSERT_EQ(a.dials.size(), b.dials.size());
  for (std::size_t i = 0; i < a.dials.size(); ++i) {
    EXPECT_EQ(a.dials[i].id, b.dials[i].id);
    EXPECT_EQ(a.dials[i].geometry.position_mm, b.dials[i].geometry.position_mm);
    EXPECT_EQ(a.dials[i].geometry.axis, b.dials[i].geometry.axis);
    EXPECT_EQ(a.dials[i].geometry.travel_mm, b.dials[i].geometry.travel_mm);
    EXPECT_EQ(a.dials[i].geometry.tip_radius_mm, b.dials[i].geometry.tip_radius_mm);
    EXPECT_EQ(a.dials[i].resolution_mm, b.dials[i].resolution_mm);
    EXPECT_EQ(a.dials[i].accuracy_mm, b.dials[i].accuracy_mm);
    EXPECT_EQ(a.dials[i].repeatability_mm, b.dials[i].repeatability_mm);
    EXPECT_EQ(a.dials[i].force_n, b.dials[i].force_n);
    EXPECT_EQ(a.dials[i].spring_n_per_mm, b.dials[i].spring_n_per_mm);
    EXPECT_EQ(a.dials[i].connection, b.dials[i].connection);
  }
}

TEST(RigFile, OfTheSharedDataIsTheDefaultRig) {
  expect_equal(parse_rig(shared_rig(), "rig.toml"), geometry::default_rig());
}

TEST(RigFile, ReadsBackWhatItWrote) {
  std::mt19937_64 random(20260302);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int tried = 0;
  for (int i = 0; i < 500; ++i) {
    geometry::Rig rig = geometry::default_rig();
    rig.name = "a \"quoted\" \\ name\twith \xC3\xA9 and a line\nend";
    rig.robot.connection = "modbus-tcp://127.0.0.1:1502?unit=1";
    for (int p = 0; p < 7; ++p) rig.robot.nominal[p] += unit(random);
    for (int p = geometry::kAlpha; p < geometry::kParameterCount; ++p) {
      // What a person would write: degrees with a few digits.
      rig.robot.nominal[p] = std::round(unit(random) * 1e6) / 1e6 * (std::numbers::pi / 180.0);
    }
    rig.cuboid.side_mm = 80 + unit(random);
    rig.cuboid.mount = i % 2 == 0 ? geometry::Mount::kDistal1 : geometry::Mount::kFree;
    rig.cuboid.reference_pose_mm += Eigen::Vector2d(unit(random), unit(random));
    for (geometry::Dial& dial : rig.dials) {
      dial.geometry.position_mm += Eigen::Vector2d(unit(random), unit(random));
      const double turn = unit(random);
      dial.geometry.axis = {std::cos(turn), std::sin(turn)};
      dial.repeatability_mm = 0.002 + 0.001 * unit(random);
      dial.connection = "serial:/dev/serial/by-id/dial-" + dial.id + "?dialect=sylvac";
    }
    const std::string text = write_rig(rig);
    expect_equal(parse_rig(text, "written"), rig);
    EXPECT_EQ(write_rig(parse_rig(text, "written")), text);
    ++tried;
  }
  EXPECT_EQ(tried, 500);
}

TEST(RigFile, KeepsAnglesOfAnyDoubleToTheirLastBit) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> angle(-0.3, 0.3);
  constexpr double kLastBit = 0x1p-53 * 0.6;  // of a double under 0.5, with some room
  for (int i = 0; i < 2000; ++i) {
    geometry::Rig rig = geometry::default_rig();
    rig.cuboid.mount = geometry::Mount::kFree;
    rig.robot.nominal[geometry::kAlpha] = angle(random);
    const double back = parse_rig(write_rig(rig), "written").robot.nominal[geometry::kAlpha];
    EXPECT_LE(std::abs(back - rig.robot.nominal[geometry::kAlpha]), kLastBit);
  }
}

TEST(RigFile, WithoutDialsServesAnInstrument) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.clear();
  EXPECT_TRUE(parse_rig(write_rig(rig), "written").dials.empty());
}

TEST(RigFile, ADialOverridesTheCommonFigures) {
  const std::string text =
      with(shared_rig(), "id = \"B\"", "id = \"B\"\ntip_radius_mm = 0\nresolution_mm = 0.0005");
  const geometry::Rig rig = parse_rig(text, "rig.toml");
  EXPECT_EQ(rig.dials[1].geometry.tip_radius_mm, 0.0);
  EXPECT_EQ(rig.dials[1].resolution_mm, 0.0005);
  EXPECT_EQ(rig.dials[2].geometry.tip_radius_mm, 1.5);
}

TEST(RigFile, ACommonConnectionServesAllDials) {
  const geometry::Rig rig = parse_rig(
      with(
          with(shared_rig(), "[dials]", "[dials]\nconnection = \"modbus-tcp://h:1\""),
          "id = \"F\"", "id = \"F\"\nconnection = \"modbus-tcp://h:2\""),
      "rig.toml");
  EXPECT_EQ(rig.dials[0].connection, "modbus-tcp://h:1");
  EXPECT_EQ(rig.dials[5].connection, "modbus-tcp://h:2");
}

TEST(RigFile, MakesAnAxisThatIsRoundedAUnitVector) {
  const geometry::Rig rig =
      parse_rig(with(shared_rig(), "axis = [-1, 0]", "axis = [-0.7071, 0.7071]"), "rig.toml");
  constexpr double kRounding = 1e-15;
  EXPECT_NEAR(rig.dials[0].geometry.axis.norm(), 1.0, kRounding);
}

TEST(RigFile, ReadsCarriageReturnsAndAByteOrderMark) {
  std::string text = shared_rig();
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2) {
    text.replace(i, 1, "\r\n");
  }
  expect_equal(parse_rig("\xEF\xBB\xBF" + text, "rig.toml"), geometry::default_rig());
}

struct WrongRig {
  std::string name;
  std::string old_text;
  std::string new_text;
  int line;
  int column;
  std::string field;
  std::string says;
};

std::vector<WrongRig> wrong_rigs() {
  return {
      {"UnknownTopKey", "name = ", "nmae = ", 2, 1, "nmae", "nearest known key is 'name'"},
      {"UnknownTable", "[cuboid]", "[cubiod]", 19, 2, "cubiod",
       "nearest known key is 'cuboid'"},
      {"UnknownRobotKey", "l12_mm", "l12_cm", 9, 1, "l12_cm", "nearest known key is 'l12_mm'"},
      {"UnknownCuboidKey", "side_mm", "sides_mm", 20, 1, "sides_mm", "'side_mm'"},
      {"UnknownDialsKey", "travel_mm", "trvel_mm", 25, 1, "trvel_mm", "'travel_mm'"},
      {"UnknownDialKey", "axis = [-1, 0]", "axes = [-1, 0]", 36, 1, "axes", "'axis'"},
      {"MissingLength", "l11_mm = 60.0\n", "", 4, 1, "l11_mm", "missing in [robot]"},
      {"MissingWorkingMode", "working_mode = \"++\" ", "# ", 4, 1, "working_mode", "missing"},
      {"MissingId", "id = \"A\"\n", "", 33, 1, "id", "missing in [[dial]]"},
      {"MissingTravel", "travel_mm = 50.8\n", "", 32, 1, "travel_mm",
       "missing in [[dial]] and in [dials]"},
      {"LengthZero", "l11_mm = 60.0", "l11_mm = 0", 8, 10, "l11_mm", "greater than 0"},
      {"LengthNegative", "l11_mm = 60.0", "l11_mm = -60", 8, 10, "l11_mm",
       "-60 makes no sense"},
      {"BaseNegative", "d_mm = 90.0", "d_mm = -90", 12, 8, "d_mm", "must not be negative"},
      {"LengthText", "l11_mm = 60.0", "l11_mm = \"60\"", 8, 10, "l11_mm", "not a number"},
      {"NotFinite", "x0_mm = 0.0", "x0_mm = nan", 13, 9, "x0_mm", "not finite"},
      {"Infinite", "x0_mm = 0.0", "x0_mm = inf", 13, 9, "x0_mm", "not finite"},
      {"Assembly", "assembly = 1 ", "assembly = 0 ", 7, 12, "assembly", "neither 1 nor -1"},
      {"AssemblyOfAnotherPose", "assembly = 1 ", "assembly = -1 ", 7, 12, "assembly",
       "does not put the tool at the reference pose"},
      {"WorkingMode", "\"++\"", "\"+\"", 6, 16, "working_mode", "\"+-\""},
      {"Model", "\"five_bar\"", "\"scara\"", 5, 9, "model", "five_bar"},
      {"SideZero", "side_mm = 80.0", "side_mm = 0.0", 20, 11, "side_mm", "greater than 0"},
      {"Mount", "\"distal2\"", "\"distal3\"", 21, 9, "mount", "'distal3' is not a mount"},
      {"ReferenceOutOfReach", "[28.0, 48.0]", "[280.0, 48.0]", 22, 21, "reference_pose_mm",
       "cannot reach"},
      {"PositionOfThree", "position_mm = [52, 48]", "position_mm = [52, 48, 1]", 35, 15,
       "position_mm", "has 3 numbers"},
      {"PositionNoNumber", "position_mm = [52, 48]", "position_mm = [52, \"48\"]", 35, 20,
       "position_mm", "not a number"},
      {"PositionNoPair", "position_mm = [52, 48]", "position_mm = 52", 35, 15, "position_mm",
       "not a pair"},
      {"AxisNotUnit", "axis = [-1, 0]", "axis = [-1, 0.1]", 36, 8, "axis", "length 1.00499"},
      {"AxisZero", "axis = [-1, 0]", "axis = [0, 0]", 36, 8, "axis", "length 0"},
      {"SameIdTwice", "id = \"B\"", "id = \"A\"", 39, 6, "id", "dial 'A' appears twice"},
      {"IdWithBlank", "id = \"B\"", "id = \"B 1\"", 39, 6, "id", "cannot name a dial"},
      {"IdNumber", "id = \"B\"", "id = 2", 39, 6, "id", "not text"},
      {"NameNumber", "name = \"five-bar rig\"", "name = 5", 2, 8, "name", "not text"},
      {"Syntax", "[robot]", "[robot", 4, 7, "", "mend the TOML syntax"},
      {"KeyTwice", "l12_mm = 60.0", "l11_mm = 60.0", 9, 10, "", "mend the TOML syntax"},
      {"LetterAfterAQuoteInAWord", "x0_mm = 0.0", "x0_mm = -1t'\xCA\x8B'", 13, 13, "",
       "not ASCII"},
      {"LetterInAStringAfterANumber", "axis = [-1, 0]", "axis = [0['a\xCE\x90']]", 36, 13, "",
       "not the value of a key"},
      {"LetterAfterABackslash", "name = \"five-bar rig\"", "name = \"rig \\\xEF\xBB\xBE\"", 2,
       14, "", "a backslash"},
      {"LetterAfterALineThatABackslashEnds", "name = \"five-bar rig\"",
       "name = \"\"\"rig \\\n  \xC3\xA9\"\"\"", 3, 3, "", "a backslash"},
      {"StrayLetter", "x0_mm = 0.0", "x0_mm = 0\xCA\x9C", 13, 10, "", "not ASCII"},
      {"StrayLetterAfterAString", "mount = \"distal2\"", "mount = \"\" \xCA\x9C", 21, 12, "",
       "not ASCII"},
      {"TravelText", "travel_mm = 50.8", "travel_mm = \"50.8\"", 25, 13, "travel_mm",
       "not a number"},
  };
}

class EveryWrongRig : public testing::TestWithParam<WrongRig> {};

TEST_P(EveryWrongRig, IsRefusedWithFileLineAndColumn) {
  const WrongRig& wrong = GetParam();
  const std::string text = with(shared_rig(), wrong.old_text, wrong.new_text);
  const DataError error = error_of([&] { (void)parse_rig(text, "rig.toml"); });
  EXPECT_EQ(error.file, "rig.toml");
  EXPECT_EQ(error.line, wrong.line) << error.what();
  EXPECT_EQ(error.column, wrong.column) << error.what();
  EXPECT_EQ(error.field, wrong.field) << error.what();
  EXPECT_FALSE(error.hint.empty());
  EXPECT_THAT(error.what(), HasSubstr(wrong.says));
}

INSTANTIATE_TEST_SUITE_P(
    , EveryWrongRig, testing::ValuesIn(wrong_rigs()),
    [](const auto& each) { return each.param.name; });

TEST(RigFile, TakesAnyCharacterInQuotesAndComments) {
  const std::vector<std::string> names{
      R"("é \" é")", R"('é \')", "\"\"\"é\n\"é\"\"\"\"", "'''é'\né'''", "\"\" # \" é"};
  for (const std::string& name : names) {
    const std::string text = with(shared_rig(), "\"five-bar rig\"", name);
    EXPECT_NO_THROW((void)parse_rig(text, "rig.toml")) << name;
  }
}

TEST(RigFile, NamesAMissingTableAndASingleDialTable) {
  EXPECT_THAT(
      error_of([] { (void)parse_rig("name = \"x\"\n", "rig.toml"); }).what(),
      HasSubstr("there is no [robot] table"));
  std::string text = small_rig();
  text = text.substr(0, text.find("[[dial]]")) + "[dial]\nid = \"A\"\n";
  EXPECT_THAT(
      error_of([&] { (void)parse_rig(text, "rig.toml"); }).what(),
      HasSubstr("write [[dial]] before each dial"));
}

TEST(Sha256, AgreesWithThePublishedExamples) {  // FIPS 180-2, appendix B
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(
      sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
      "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(
      sha256(std::string(1'000'000, 'a')),
      "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace sixdial::session
