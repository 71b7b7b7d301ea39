#include "session/rig_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "geometry/units.h"
#include "session/csv.h"
#include "session/sha256.h"
#include "tests/session/bundle_text.h"
#include "tests/session/same_rig.h"
#include "tests/support/paths.h"

namespace sixdial::session {
namespace {

using testing::HasSubstr;

std::string shared_rig() {
  return read_file(test_paths::test_data() + "/sessions/00/rig.toml");
}

TEST(RigFile, OfTheSharedDataIsTheDefaultRig) {
  expect_same(parse_rig(shared_rig(), "rig.toml"), geometry::default_rig());
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
    expect_same(parse_rig(text, "written"), rig);
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

TEST(RigFile, KeepsATolerance) {
  const std::string text = "tolerance_mm = 0.05\n" + shared_rig();
  geometry::Rig rig = parse_rig(text, "rig.toml");
  ASSERT_TRUE(rig.tolerance_mm);
  EXPECT_EQ(*rig.tolerance_mm, 0.05);
  EXPECT_EQ(parse_rig(write_rig(rig), "rig.toml").tolerance_mm, rig.tolerance_mm);
  rig.tolerance_mm.reset();
  EXPECT_FALSE(parse_rig(write_rig(rig), "rig.toml").tolerance_mm);
  EXPECT_FALSE(parse_rig(shared_rig(), "rig.toml").tolerance_mm);
  for (const char* wrong : {"0.0", "-1", "\"fine\""}) {
    EXPECT_ANY_THROW(static_cast<void>(
        parse_rig(fmt::format("tolerance_mm = {}\n{}", wrong, shared_rig()), "rig.toml")))
        << wrong;
  }
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
  expect_same(parse_rig("\xEF\xBB\xBF" + text, "rig.toml"), geometry::default_rig());
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

/// [robot] of the small rig, without a cuboid and without dials.
std::string robot_alone() {
  const std::string text = small_rig();
  return text.substr(0, text.find("[cuboid]"));
}

TEST(RigFile, WithoutCuboidAndDialsIsOneOfPositions) {
  const geometry::Rig rig = parse_rig(robot_alone(), "rig.toml");
  EXPECT_EQ(rig.instrument.kind, "position");
  EXPECT_TRUE(rig.dials.empty());
  EXPECT_EQ(rig.robot.nominal, parse_rig(small_rig(), "rig.toml").robot.nominal);
  const geometry::Rig again = parse_rig(write_rig(rig), "rig.toml");
  expect_same(again, rig);
  EXPECT_EQ(again.instrument.kind, "position");
}

TEST(RigFile, NamesItsInstrument) {
  const std::string text =
      robot_alone() + "[instrument]\nkind = \"position\"\nsd_mm = 0.02\ndimensions = 3\n";
  const geometry::Rig rig = parse_rig(text, "rig.toml");
  EXPECT_EQ(rig.instrument.kind, "position");
  EXPECT_EQ(rig.instrument.sd_mm, 0.02);
  EXPECT_EQ(rig.instrument.dimensions, 3);
  const geometry::Rig again = parse_rig(write_rig(rig), "rig.toml");
  EXPECT_EQ(again.instrument.sd_mm, 0.02);
  EXPECT_EQ(again.instrument.dimensions, 3);
  EXPECT_THAT(
      error_of([] {
        (void)parse_rig(robot_alone() + "[instrument]\nkind = \"ruler\"\n", "rig.toml");
      }).what(),
      testing::AllOf(HasSubstr("not a known instrument"), HasSubstr("\"dials_on_cuboid\"")));
}

TEST(RigFile, ATableMisspeltIsNoRigOfPositions) {
  EXPECT_THAT(
      error_of([] { (void)parse_rig(robot_alone() + "[cubiod]\n", "rig.toml"); }).what(),
      HasSubstr("nearest known key is 'cuboid'"));
}

// A robot kind that the program does not have: three joints, a key of its own.
struct Slide {
  std::string colour;
};
std::shared_ptr<const geometry::RobotModel> slide_of(std::string colour) {
  auto robot = std::make_shared<geometry::RobotModel>();
  robot->kind = geometry::find_robot_kind("slide");
  robot->joints = {
      {"x", geometry::JointKind::kPrismatic},
      {"y", geometry::JointKind::kPrismatic},
      {"z", geometry::JointKind::kPrismatic}};
  robot->parameters = {
      {"skew", "skew_deg", "deg", geometry::kDegPerRad, "rad", 0.01},
      {"scale", "scale_mm", "mm", 1.0, "mm", 1.0, geometry::FileRange::kPositive}};
  robot->parameters.back().optional = true;
  robot->nominal = Eigen::Vector2d(0.0, 100.0);
  robot->frames = {"E"};
  robot->assemblies = {{1, "the one"}};
  robot->modes = {{0, "the one"}};
  robot->details = std::make_shared<const Slide>(Slide{std::move(colour)});
  return robot;
}
void add_slide() {
  static constexpr std::array<std::string_view, 1> kKeys{"colour"};
  if (geometry::find_robot_kind("slide") != nullptr) return;
  geometry::add_robot_kind(
      {.name = "slide",
       .in_words = "three slides",
       .example = [] { return slide_of("grey"); },
       .from_file = [](const geometry::RobotFile& file)
           -> tl::expected<
               std::shared_ptr<const geometry::RobotModel>, geometry::RobotFileFault> {
         const auto colour = file.robot.find("colour");
         if (colour == file.robot.end()) return slide_of("grey");
         const auto* text = std::get_if<std::string>(&colour->second.value);
         if (text != nullptr) return slide_of(*text);
         return tl::unexpected(
             geometry::RobotFileFault{"colour", "is no colour", "write \"red\""});
       },
       .file_keys = kKeys,
       .to_file =
           [](const geometry::RobotModel& robot, const Eigen::VectorXd&) {
             geometry::RobotFileText text;
             text.robot["colour"] = {static_cast<const Slide*>(robot.details.get())->colour};
             return text;
           },
       .forward = [](const geometry::RobotModel&, std::span<const double> v,
                     std::span<const double> q, geometry::Assembly,
                     std::span<geometry::Pose<double>> X) -> geometry::Reached {
         X[0].p = Eigen::Vector3d(q[0], q[1] + v[0] * q[0], q[2]) * (v[1] / 100.0);
         return {};
       },
       .forward_derivative = [](const geometry::RobotModel& robot, std::span<const double> v,
                                std::span<const double> q, geometry::Assembly assembly,
                                geometry::Frames& at) -> geometry::Reached {
         return robot.kind->forward(robot, v, q, assembly, at.X);
       }});
}

TEST(RigFile, TakesAnyRobotKindByItsName) {
  add_slide();
  const std::string text =
      "name = \"mill\"\n[robot]\nmodel = \"slide\"\ncolour = \"red\"\nskew_deg = 0.5\n";
  const geometry::Rig rig = parse_rig(text, "rig.toml");
  EXPECT_EQ(rig.robot.model->joint_count(), 3);
  ASSERT_EQ(rig.robot.nominal.size(), 2);
  EXPECT_DOUBLE_EQ(rig.robot.nominal[0], 0.5 * geometry::kRadPerDeg);
  EXPECT_EQ(rig.robot.nominal[1], 100.0);  // optional: the kind's own
  EXPECT_EQ(static_cast<const Slide*>(rig.robot.model->details.get())->colour, "red");
  const geometry::Rig again = parse_rig(write_rig(rig), "rig.toml");
  EXPECT_EQ(again.robot.nominal, rig.robot.nominal);
  EXPECT_EQ(static_cast<const Slide*>(again.robot.model->details.get())->colour, "red");
  EXPECT_THAT(
      error_of([&] { (void)parse_rig(with(text, "\"red\"", "3"), "rig.toml"); }).what(),
      HasSubstr("is no colour"));
  EXPECT_THAT(
      error_of([&] { (void)parse_rig(with(text, "skew_deg", "skow_deg"), "rig.toml"); }).what(),
      HasSubstr("the nearest known key is 'skew_deg'"));
}

constexpr const char* kArm =
    "name = \"arm\"\n[robot]\nmodel = \"serial\"\nbase_rz_deg = 90\ntool_z_mm = 50\n"
    "[[joint]]\nd_mm = 300\nalpha_deg = 90\n"
    "[[joint]]\nname = \"elbow\"\na_mm = 250\nlow_deg = -170\nhigh_deg = 170\n"
    "[[joint]]\nkind = \"prismatic\"\nalpha_deg = 90\ntheta_deg = 90\n"
    "[instrument]\nkind = \"position\"\nsd_mm = 0.02\n";

TEST(RigFile, AnArmIsReadAndWrittenBack) {
  const geometry::Rig rig = parse_rig(kArm, "rig.toml");
  const geometry::RobotModel& robot = *rig.robot.model;
  ASSERT_EQ(robot.joint_count(), 3);
  EXPECT_EQ(robot.joints[1].name, "elbow");
  EXPECT_EQ(robot.joints[2].kind, geometry::JointKind::kPrismatic);
  EXPECT_EQ(rig.instrument.dimensions, 3);
  const std::string text = write_rig(rig);
  const geometry::Rig again = parse_rig(text, "rig.toml");
  EXPECT_EQ(write_rig(again), text);
  EXPECT_EQ(again.robot.nominal, rig.robot.nominal);
  // What a calibration finds can be written and read, too.
  geometry::Rig other = rig;
  for (Eigen::Index i = 0; i < other.robot.nominal.size(); ++i) {
    other.robot.nominal[i] += 0.013 * static_cast<double>(i);
  }
  const geometry::Rig found = parse_rig(write_rig(other), "rig.toml");
  const Eigen::Vector3d q(0.3, -0.4, 12.0);
  std::vector<geometry::Pose<double>> X(4);
  std::vector<geometry::Pose<double>> expected(4);
  ASSERT_TRUE(robot.forward(other.robot.nominal, q, other.robot.assembly, expected));
  ASSERT_TRUE(found.robot.model->forward(found.robot.nominal, q, found.robot.assembly, X));
  EXPECT_LT((X[0].p - expected[0].p).norm(), 1e-10);
}

TEST(RigFile, SaysWhatIsWrongWithAnArm) {
  const auto error = [](const std::string& find, const std::string& put) {
    return std::string(
        error_of([&] { (void)parse_rig(with(kArm, find, put), "rig.toml"); }).what());
  };
  EXPECT_THAT(error("d_mm = 300", "d_mm = \"long\""), HasSubstr("rig.toml:7"));
  EXPECT_THAT(error("d_mm = 300", "e_mm = 300"), HasSubstr("is not a key of [[joint]]"));
  EXPECT_THAT(error("low_deg = -170", "low_mm = -170"), HasSubstr("write low_deg"));
  EXPECT_THAT(error("low_deg = -170", "low_deg = 180"), HasSubstr("is not above low_deg"));
  EXPECT_THAT(error("\"prismatic\"", "\"sliding\""), HasSubstr("revolute"));
  EXPECT_THAT(error("name = \"elbow\"", "name = \"q1\""), HasSubstr("appears twice"));
  EXPECT_THAT(error("a_mm = 250", "origin_mm = [1, 2, 3]"), HasSubstr("convention"));
  EXPECT_THAT(
      error("tool_z_mm = 50", "urdf = \"arm.urdf\""), HasSubstr("leave one of them out"));
  EXPECT_THAT(
      error_of([] {
        (void)parse_rig("name = \"x\"\n[robot]\nmodel = \"serial\"\n", "rig.toml");
      }).what(),
      HasSubstr("add a [[joint]] table"));
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
