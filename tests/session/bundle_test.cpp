#include "session/bundle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "session/csv.h"
#include "tests/session/bundle_text.h"
#include "tests/support/paths.h"

namespace sixdial::session {
namespace {

using testing::HasSubstr;

const std::string kGood = kHeader + "\n" + kRow0 + "\n" + kRow1 + "\n";

class EverySharedBundle : public testing::TestWithParam<const char*> {};

TEST_P(EverySharedBundle, GivesTheSameBytesBack) {
  const std::string folder = test_paths::test_data() + "/sessions/" + GetParam();
  const Session session = read_bundle(folder);
  EXPECT_EQ(session.samples.size(), 150U);
  EXPECT_EQ(session.name, GetParam());
  EXPECT_EQ(session_csv(session), read_file(folder + "/session.csv"));
  EXPECT_EQ(rig_toml(session), read_file(folder + "/rig.toml"));
}

// Without the rows as read, the writer has to find the same digits by itself.
TEST_P(EverySharedBundle, IsWrittenFromItsNumbersWithTheSameBytes) {
  const std::string folder = test_paths::test_data() + "/sessions/" + GetParam();
  Session session = read_bundle(folder);
  session.csv_header.clear();
  for (Sample& sample : session.samples) sample.source_row.clear();
  EXPECT_EQ(session_csv(session), read_file(folder + "/session.csv"));
}

INSTANTIATE_TEST_SUITE_P(Data, EverySharedBundle, testing::Values("00", "01", "12"));

struct OddCase {
  std::string name;
  std::string csv;
  std::size_t rows = 2;
};

std::string crlf(std::string text) {
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2) {
    text.replace(i, 1, "\r\n");
  }
  return text;
}

std::string without_last(std::string text, std::size_t count) {
  text.resize(text.size() - count);
  return text;
}

std::vector<OddCase> odd_cases() {
  const std::string extra = kHeader + ",operator,\"a,b\"\n" + kRow0 +
                            ",\"Ann, \"\"A\"\"\",1\n" + kRow1 + ",,\"x\ny\"\n";
  return {
      {"Plain", kGood},
      {"CarriageReturns", crlf(kGood)},
      {"MixedLineEnds", kHeader + "\r\n" + kRow0 + "\n" + kRow1 + "\r\n"},
      {"MixedTheOtherWay", kHeader + "\n" + kRow0 + "\r\n" + kRow1},
      {"ByteOrderMark", "\xEF\xBB\xBF" + kGood},
      {"NoFinalNewline", without_last(kGood, 1)},
      {"NoFinalNewlineAfterCarriageReturns", without_last(crlf(kGood), 2)},
      {"FinalLoneCarriageReturn", without_last(crlf(kGood), 1)},
      {"BlankLinesAtTheEnd", kGood + "\n\r\n\n"},
      {"BlankLinesAfterCarriageReturns", crlf(kGood) + "\r\n\n"},
      {"UnknownColumnsWithQuotes", extra},
      {"UnknownColumnsWithCarriageReturns", crlf(extra)},
      {"QuotedNumbers", with(kGood, "1.509623367", "\"1.509623367\"")},
      {"BlanksAndPlus", with(kGood, "1.509623367", " +1.509623367 ")},
      {"QuotedHeader", with(kGood, "set,", "\"set\",")},
      {"EmptyOptionalFields", with(kGood, "18.402564,54.249290,0,0,20.03", ",,,,")},
      {"NoSamples", kHeader + "\n", 0},
      {"HeaderAlone", kHeader, 0},
      // A clock that was set back: the rows stand in the order of measuring.
      {"TimeBackwards", with(kGood, "08:30:17", "08:30:07")},
      {"BlanksAroundASet", with(with(kGood, "G1,0", " G1,0"), "G1,1", "G1\u00A0,1")},
      {"ColumnsWithoutANameOrValues", kHeader + ",,\n" + kRow0 + ",,\n" + kRow1 + ", ,\n"},
      {"ColumnsWithoutANameInTheHeader", kHeader + ",,\n" + kRow0 + "\n" + kRow1 + "\n"},
      {"ColumnsWithoutANameInTheRows", kHeader + "\n" + kRow0 + ",,\n" + kRow1 + ",,\n"},
      {"RowsOfSeparatorsAtTheEnd", kGood + ",,,,\n,,\n"},
      {"RowsOfSeparatorsAtTheEndWithoutANewline", kGood + ",,,,"},
      {"AccentsInNames", with(kGood, "G1,0", "G\xC3\xA9,0")},
  };
}

class EveryOddBundle : public testing::TestWithParam<OddCase> {};

TEST_P(EveryOddBundle, GivesTheSameBytesBack) {
  const Session session = parse(GetParam().csv);
  EXPECT_EQ(session.samples.size(), GetParam().rows);
  EXPECT_EQ(session_csv(session), GetParam().csv);
  if (GetParam().rows > 0) {
    EXPECT_DOUBLE_EQ(session.samples[0].q[0], 1.509623367);
    EXPECT_DOUBLE_EQ(session.samples[1].channels[5].value.value_or(0), 31.040);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryOddBundle, testing::ValuesIn(odd_cases()),
    [](const auto& each) { return each.param.name; });

TEST(Bundle, KeepsEveryFieldOfARow) {
  const Session session = parse(kGood);
  const Sample& sample = session.samples[1];
  EXPECT_EQ(sample.set, "G1");
  EXPECT_EQ(sample.point, 1);
  EXPECT_EQ(sample.repeat, 0);
  EXPECT_EQ(to_iso8601(sample.time_utc.value()), "2026-03-02T08:30:17.693Z");
  EXPECT_EQ(sample.q, Eigen::Vector2d(1.411917868, 2.880616311));
  EXPECT_EQ(sample.target_mm, Eigen::Vector2d(24.408706, 62.417123));
  EXPECT_EQ(sample.approach[0], -1);
  EXPECT_EQ(sample.temperature_c, 20.07);
  ASSERT_EQ(sample.channels.size(), 6U);
  EXPECT_EQ(sample.channels[0].value, 14.486);
  EXPECT_EQ(sample.line, 3);
  EXPECT_EQ(sample.source_row, kRow1);
}

TEST(Bundle, ABlankThatNobodySeesMakesNoOtherSet) {
  const Session session = parse(with(with(kGood, "G1,0", " G1\t,0"), "G1,1", "G1\u00A0,1"));
  EXPECT_EQ(session.samples[0].set, "G1");
  EXPECT_EQ(session.samples[1].set, "G1");
}

TEST(Bundle, TakesDialColumnsInAnyOrderAndPositionsInstead) {
  const Session session = parse(
      "x_mm,y_mm,dial_F_mm,theta2_rad,theta1_rad,dial_A_mm,set\n"
      "18.5,54.25,26.045,3.069803861,1.509623367,,G1\n"
      ",,26.045,3.069803861,1.509623367,1,G1\n");
  ASSERT_EQ(session.samples.size(), 2U);
  EXPECT_EQ(position_of(session.samples[0], 6), Eigen::Vector2d(18.5, 54.25));
  EXPECT_EQ(session.samples[0].channels[5].value, 26.045);
  EXPECT_FALSE(session.samples[0].channels[0].value.has_value());
  EXPECT_EQ(session.samples[0].channels[0].reason, "no contact or no reading");
  EXPECT_EQ(session.samples[0].channels[1].reason, "no column in the file");
  EXPECT_FALSE(position_of(session.samples[1], 6).has_value());
  EXPECT_EQ(session.samples[1].point, 1) << "points without a column are numbered";
}

struct WrongCase {
  std::string name;
  std::string csv;
  int line;
  int column;
  std::string field;
  std::string says;  // part of the message
};

// Columns are counted by hand in the rows above: theta1_rad starts at 33, dial_A_mm at 87.
std::vector<WrongCase> wrong_cases() {
  const int after_header = static_cast<int>(kHeader.size()) + 1;
  return {
      {"Empty", "", 1, 1, "", "empty"},
      {"OnlyBlankLines", "\n\n", 1, 1, "", "empty"},
      {"MissingSet", with(kGood, "set,", "Set,"), 1, after_header, "set",
       "column is missing; add it: G1 calibrates, G2 validates; was 'Set' meant?"},
      {"MissingAngle", with(kGood, "theta2_rad", "theta2_deg"), 1, after_header, "theta2_rad",
       "'theta2_deg' meant"},
      {"NoDialsAndNoPosition", "set,theta1_rad,theta2_rad\nG1,1.5,3.0\n", 1, 26, "",
       "no dial columns"},
      {"HalfAPosition", "set,theta1_rad,theta2_rad,x_mm\nG1,1.5,3.0,1\n", 1, 31, "y_mm",
       "missing"},
      {"Semicolons", "set;theta1_rad;theta2_rad\nG1;1,5;3,0\n", 1, 26, "set", "commas"},
      {"DialNotInTheRig", with(kGood, "dial_C_mm", "dial_Q_mm"), 1,
       static_cast<int>(kHeader.find("dial_C_mm")) + 1, "dial_Q_mm",
       "dial 'Q' is not in the rig file; the rig file's dials: A, B, C, D, E, F"},
      {"ColumnTwice", with(kGood, "dial_C_mm", "dial_B_mm"), 1,
       static_cast<int>(kHeader.find("dial_C_mm")) + 1, "dial_B_mm", "twice"},
      {"TextInAnAngle", with(kGood, "1.509623367", "1.5o9623367"), 2, 33, "theta1_rad",
       "'1.5o9623367' is not a number"},
      {"TextInADial", with(kGood, "8.513", "n/a"), 2, 87, "dial_A_mm", "'n/a'"},
      {"NumberWithUnit", with(kGood, "8.513", "8.513 mm"), 2, 87, "dial_A_mm", "not a number"},
      {"NotANumberValue", with(kGood, "8.513", "nan"), 2, 87, "dial_A_mm", "not a finite"},
      {"Infinity", with(kGood, "8.513", "-inf"), 2, 87, "dial_A_mm", "not a finite"},
      {"TooLargeForADouble", with(kGood, "8.513", "1e999"), 2, 87, "dial_A_mm", "not a finite"},
      {"EmptyAngle", with(kGood, "1.509623367", ""), 2, 33, "theta1_rad", "empty"},
      {"EmptySet", with(kGood, "G1,1", ",1"), 3, 1, "set", "empty"},
      {"NegativePoint", with(kGood, "G1,1", "G1,-1"), 3, 4, "point", "'-1'"},
      {"FractionalPoint", with(kGood, "G1,1", "G1,1.0"), 3, 4, "point", "whole number"},
      {"TooManyFields", with(kGood, "8.513", "8,513"), 2, 120, "",
       "18 fields, the header has 17"},
      {"TooFewFields", with(kGood, "8.513,", ""), 2, 114, "dial_E_mm", "16 fields"},
      {"BlankLineInside", with(kGood, kRow1, "\n" + kRow1), 3, 1, "set", "1 fields"},
      {"OutOfReach", with(kGood, "3.069803861", "0.1"), 2, 33, "theta1_rad",
       "joint angles (1.509623367, 0.1) rad are out of reach"},
      {"DegreesForRadians", with(kGood, "1.509623367,3.069803861", "86.5,175.9"), 2, 33,
       "theta1_rad", "out of reach"},
      {"SamePointTwice", with(kGood, "G1,1", "G1,0"), 3, 4, "point",
       "set G1, point 0, repeat 0 stands in line 2 already"},
      {"NoHeader", kRow0 + "\n" + kRow1 + "\n", 1, 1, "",
       "the first line is no header: it has values; put a line with the names of the columns "
       "above it: set,point"},
      {"NoTime", with(kGood, "2026-03-02T08:30:17.693Z", "yesterday"), 3, 8, "time_utc",
       "'yesterday'"},
      {"NoSuchDay", with(kGood, "2026-03-02T08:30:17", "2026-02-30T08:30:17"), 3, 8, "time_utc",
       "not a time"},
      {"LocalTime", with(kGood, "17.693Z", "17.693"), 3, 8, "time_utc", "not a time"},
      {"BadApproach", with(kGood, "-1,-1", "-2,-1"), 3, 77, "approach1", "not -1, 0 or 1"},
      {"HalfATarget", with(kGood, "24.408706", ""), 3, 57, "target_x_mm", "partner"},
      {"BelowAbsoluteZero", with(kGood, "20.07", "-300"), 3, 83, "temperature_c",
       "absolute zero"},
      {"OpenQuote", with(kGood, "G1,1", "\"G1,1"), 3, 1, "", "never closed"},
      {"TextAfterAQuote", with(kGood, "G1,1", "\"G1\"x,1"), 3, 1, "",
       "follows a closing quote"},
      {"NotUtf8", with(kGood, "G1,1", "G\xE9,1"), 3, 2, "", "0xe9 is not UTF-8"},
      {"ZeroByte", with(kGood, "G1,1", std::string("G\0,1", 4)), 3, 2, "", "0x00"},
      {"Utf16", std::string("\xFF\xFEs\0e\0", 6), 1, 1, "", "UTF-16"},
      {"Utf16WithoutAMark", std::string("\0s\0e\0t", 6), 1, 1, "", "UTF-16"},
      {"Gzip", "\x1F\x8B\x08", 1, 1, "", "compressed (gzip); unpack it first"},
      {"Spreadsheet", "PK\x03\x04\x14", 1, 1, "", "spreadsheet (.xlsx, .ods); export"},
      {"CarriageReturnsAlone", kHeader + "\r" + kRow0 + "\r", 1, 1, "", "old Mac"},
      {"UnitsBelowTheHeader",
       with(kGood, kRow0, ",,,,rad,rad,mm,mm,,,degC,mm,mm,mm,mm,mm,mm\n" + kRow0), 2, 1, "set",
       "no field of this row is a number"},
      {"HeaderAgain", with(kGood, kRow1, kHeader), 3, 1, "", "stand here again"},
      {"DialInOtherLetters", with(kGood, "dial_A_mm", "Dial_A_MM"), 1,
       static_cast<int>(kHeader.find("dial_A_mm")) + 1, "Dial_A_MM", "was 'dial_A_mm' meant?"},
      {"DialWithoutItsUnit", with(kGood, "dial_A_mm", "dial A"), 1,
       static_cast<int>(kHeader.find("dial_A_mm")) + 1, "dial A", "was 'dial_A_mm' meant?"},
      {"TemperatureWithoutItsUnit", with(kGood, "temperature_c", "temperature"), 1,
       static_cast<int>(kHeader.find("temperature_c")) + 1, "temperature", "'temperature_c'"},
      {"ALetterLess", with(kGood, "approach1", "aproach1"), 1,
       static_cast<int>(kHeader.find("approach1")) + 1, "aproach1", "'approach1' meant?"},
      {"BlanksAroundAName", with(kGood, "point", " point "), 1,
       static_cast<int>(kHeader.find("point")) + 1, " point ", "was 'point' meant?"},
  };
}

class EveryWrongBundle : public testing::TestWithParam<WrongCase> {};

TEST_P(EveryWrongBundle, IsRefusedWithFileLineAndColumn) {
  const WrongCase& wrong = GetParam();
  const DataError error = error_of([&] { (void)parse(wrong.csv); });
  EXPECT_EQ(error.file, "session.csv");
  EXPECT_EQ(error.line, wrong.line) << error.what();
  EXPECT_EQ(error.column, wrong.column) << error.what();
  EXPECT_EQ(error.field, wrong.field) << error.what();
  EXPECT_FALSE(error.hint.empty()) << error.what();
  EXPECT_THAT(error.what(), HasSubstr(wrong.says));
  EXPECT_THAT(
      error.what(), testing::StartsWith(
                        "session.csv:" + std::to_string(wrong.line) + ":" +
                        std::to_string(wrong.column) + ": "));
}

INSTANTIATE_TEST_SUITE_P(
    , EveryWrongBundle, testing::ValuesIn(wrong_cases()),
    [](const auto& each) { return each.param.name; });

TEST(WrongBundle, ReportsTwentyFaultsAndCountsTheRest) {
  std::string csv = kHeader + "\n";
  for (int i = 0; i < 30; ++i) {
    csv += with(with(kRow0, "G1,0", "G1," + std::to_string(i)), "8.513", "bad") + "\n";
  }
  const DataError error = error_of([&] { (void)parse(csv); });
  EXPECT_EQ(error.total, 30U);
  EXPECT_EQ(error.mistakes.size(), 20U);
  EXPECT_EQ(error.mistakes[19].line, 21);
  EXPECT_THAT(error.what(), HasSubstr("and 10 more"));
}

TEST(WrongBundle, NamesAMissingFile) {
  const DataError error =
      error_of([] { (void)read_bundle(test_paths::test_data() + "/no_such_folder"); });
  EXPECT_THAT(error.what(), HasSubstr("no_such_folder: there is no such folder or file"));
}

TEST(SkipBadRows, LeavesThemOutListsThemAndKeepsTheRest) {
  const std::string bad = with(with(kRow1, "G1,1", "G1,7"), "14.486", "oops");
  const std::string duplicate = kRow1;
  const Session session = parse(
      kHeader + "\n" + kRow0 + "\n" + bad + "\n" + kRow1 + "\n" + duplicate + "\n",
      {.skip_bad_rows = true, .name = "skipped"});
  EXPECT_EQ(session.name, "skipped");
  EXPECT_EQ(session.samples.size(), 2U);
  ASSERT_EQ(session.rejected.size(), 2U);
  EXPECT_EQ(session.rejected[0].line, 3);
  EXPECT_EQ(session.rejected[0].text, bad);
  EXPECT_THAT(session.rejected[0].reason, HasSubstr("session.csv:3:"));
  EXPECT_THAT(session.rejected[0].reason, HasSubstr("'oops' is not a number"));
  EXPECT_EQ(session.rejected[1].line, 5);
  EXPECT_EQ(session_csv(session), kHeader + "\n" + kRow0 + "\n" + kRow1 + "\n");
}

TEST(SkipBadRows, ARejectedRowDoesNotBlockItsPointOrItsTime) {
  // Line 2 is bad and late; the good row after it is earlier and has the same key.
  const std::string late = with(with(kRow0, "08:30:08", "09:30:08"), "8.513", "bad");
  const Session session =
      parse(kHeader + "\n" + late + "\n" + kRow0 + "\n", {.skip_bad_rows = true, .name = ""});
  EXPECT_EQ(session.samples.size(), 1U);
  EXPECT_EQ(session.rejected.size(), 1U);
}

TEST(SkipBadRows, DoesNotExcuseABadHeader) {
  (void)error_of([] {
    (void)parse(with(kGood, "dial_C_mm", "dial_Q_mm"), {.skip_bad_rows = true, .name = ""});
  });
}

Sample measured(int point) {
  Sample sample;
  sample.set = "G1";
  sample.point = point;
  sample.time_utc = from_iso8601("2026-03-02T08:30:08.805Z");
  sample.q = Eigen::Vector2d(150962337 * 1e-8, 306980386 * 1e-8);
  sample.target_mm = Eigen::Vector2d(18.402564, 54.24929);
  sample.approach = {1, -1};
  sample.temperature_c = 20.03;
  sample.channels.resize(6);
  for (std::size_t i = 0; i < 6; ++i) {
    sample.channels[i].value = static_cast<double>(1000 * i + 7) * 0.001;
  }
  return sample;
}

TEST(MeasuredSession, IsWrittenInTheSpecsColumnsAndReadsBackEqual) {
  Session session;
  session.rig = geometry::default_rig();
  session.samples = {measured(0), measured(1)};
  session.samples[1].channels[2].value.reset();
  session.samples[1].channels[2].reason = "timeout";
  const std::string csv = session_csv(session);
  EXPECT_EQ(
      csv,
      kHeader +
          "\nG1,0,0,2026-03-02T08:30:08.805Z,1.509623370,3.069803860,18.402564,54.249290,1,"
          "-1,20.03,0.007,1.007,2.007,3.007,4.007,5.007"
          "\nG1,1,0,2026-03-02T08:30:08.805Z,1.509623370,3.069803860,18.402564,54.249290,1,"
          "-1,20.03,0.007,1.007,,3.007,4.007,5.007\n");
  const Session back = parse_session(csv, "session.csv", rig_toml(session), "rig.toml");
  ASSERT_EQ(back.samples.size(), 2U);
  EXPECT_DOUBLE_EQ(back.samples[0].q[0], session.samples[0].q[0]);
  EXPECT_EQ(session_csv(back), csv);
}

TEST(MeasuredSession, GivesBackEveryStepOfAFinerDial) {
  Session session;
  session.rig = geometry::default_rig();
  for (geometry::Dial& dial : session.rig.dials) dial.resolution_mm = 0.0005;
  session.samples = {measured(0)};
  session.samples[0].channels[0].value = 12.3455;
  session.samples[0].channels[1].value = 1.234567;  // finer than the rig file says
  const Session back =
      parse_session(session_csv(session), "session.csv", rig_toml(session), "rig.toml");
  EXPECT_EQ(back.samples[0].channels[0].value, 12.3455);
  EXPECT_EQ(back.samples[0].channels[1].value, 1.234567);
}

TEST(MeasuredSession, WritesABadReadingAsNone) {
  Session session;
  session.rig = geometry::default_rig();
  session.samples = {measured(0)};
  session.samples[0].channels[0].quality = Quality::kBad;
  session.samples[0].channels[1].quality = Quality::kUncertain;
  const Session back =
      parse_session(session_csv(session), "session.csv", rig_toml(session), "rig.toml");
  EXPECT_FALSE(back.samples[0].channels[0].value.has_value());
  EXPECT_EQ(back.samples[0].channels[1].value, 1.007);
}

TEST(MeasuredSession, AddedToAnImportedOneFollowsItsHeader) {
  Session session = parse(
      "note,dial_B_mm,set,point,theta1_rad,theta2_rad\r\nfirst,25.194,G1,0,1.509623367,"
      "3.069803861\r\n");
  session.samples.push_back(measured(1));
  EXPECT_EQ(
      session_csv(session),
      "note,dial_B_mm,set,point,theta1_rad,theta2_rad\r\nfirst,25.194,G1,0,1.509623367,"
      "3.069803861\r\n,1.007,G1,1,1.509623370,3.069803860\r\n");
}

TEST(MeasuredSession, SaysWhatIsWrongWithASample) {
  const geometry::Rig rig = geometry::default_rig();
  EXPECT_EQ(sample_problem(rig, measured(0)), "");
  Sample sample = measured(0);
  sample.channels[3].value = std::nan("");
  EXPECT_EQ(sample_problem(rig, sample), "the reading of dial D is not finite");
  sample = measured(0);
  sample.channels.pop_back();
  EXPECT_EQ(sample_problem(rig, sample), "there are 5 dial readings for 6 dials");
  sample = measured(0);
  sample.q[1] = 0.1;
  EXPECT_EQ(sample_problem(rig, sample), "") << "out of nominal reach is still a measurement";
  sample.q[1] = HUGE_VAL;
  EXPECT_EQ(sample_problem(rig, sample), "a joint angle is not finite");
}

TEST(Bundle, IsWrittenToAFolderAndReadAgain) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                       ("sixdial_bundle_" + std::to_string(::getpid())) /
                                       "inner";
  const Session session = parse(kGood);
  write_bundle(session, folder);
  EXPECT_EQ(read_file((folder / "session.csv").string()), kGood);
  EXPECT_EQ(read_file((folder / "rig.toml").string()), small_rig());
  EXPECT_EQ(read_bundle(folder).name, "inner");
  EXPECT_EQ(read_bundle(folder / "session.csv").samples.size(), 2U);
  EXPECT_EQ(
      std::distance(
          std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()),
      2)
      << "no part files are left";
  std::filesystem::remove_all(folder.parent_path());
}

TEST(Iso8601, ClosesOnEveryMillisecondItIsGiven) {
  for (const char* text :
       {"2026-03-02T08:30:06.976Z", "1970-01-01T00:00:00.000Z", "2024-02-29T23:59:59.999Z",
        "0001-01-01T00:00:00.001Z", "9999-12-31T23:59:59.999Z"}) {
    const auto time = from_iso8601(text);
    ASSERT_TRUE(time.has_value()) << text;
    EXPECT_EQ(to_iso8601(*time), text);
  }
  EXPECT_EQ(from_iso8601("2026-03-02T08:30:06Z"), from_iso8601("2026-03-02T08:30:06.000Z"));
  EXPECT_EQ(from_iso8601("2026-03-02T08:30:06.9Z"), from_iso8601("2026-03-02T08:30:06.900Z"));
  for (const char* text :
       {"", "Z", "2026-03-02", "2026-13-02T08:30:06Z", "2026-03-02T24:00:00Z",
        "2026-03-02T08:30:06.Z", "2026-03-02T08:30:06,9Z", "2026-03-02 08:30:06Z",
        "2026-03-02T08:30:06+01:00", "2025-02-29T00:00:00Z"}) {
    EXPECT_FALSE(from_iso8601(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace sixdial::session
