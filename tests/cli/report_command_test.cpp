// The report's PDF and its comparison of two sessions, as the command line makes them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

#include "cli/cli.h"
#include "report/documents/calibration_json.h"
#include "report/sections/against_sections.h"
#include "service/report_pdf.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using ::testing::HasSubstr;
using testing::TempDirectory;

const std::string kSessions = test_paths::test_data() + "/sessions/";

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

int sixdial(std::vector<std::string> words, std::string& err) {
  words.insert(words.begin(), "sixdial");
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  std::ostringstream out, errors;
  const int code = cli::run(static_cast<int>(arguments.size()), arguments.data(), out, errors);
  err = errors.str();
  return code;
}

studies::CalibrationResult calibrated(const session::Session& session) {
  studies::CalibrationRequest request;
  request.qpso1_iterations = 5;
  request.qpso2_iterations = 20;
  request.anfis_epochs = 5;
  return studies::calibrate(session, request, [](const studies::Progress&) {});
}

const report::Table& table_of(const report::Section& section, const std::string& id) {
  for (const report::Block& block : section.blocks) {
    const auto* table = std::get_if<report::Table>(&block);
    if (table != nullptr && table->id == id) return *table;
  }
  throw std::runtime_error("no table " + id);
}

double value(const report::Cell& cell) { return std::get<report::Number>(cell).value; }

TEST(Against, ASessionAgainstItselfHasNotChanged) {
  const session::Session session = session::read_bundle(kSessions + "00");
  const studies::CalibrationResult result = calibrated(session);
  const auto sections = report::against_sections({result, session}, {result, session});
  const report::Table& t = table_of(sections.at(0), "against_parameters");
  ASSERT_EQ(t.rows.size(), 10U);
  for (const auto& row : t.rows) {
    EXPECT_EQ(value(row[6]), 0.0);  // exactly: the same numbers
    EXPECT_EQ(std::get<std::string>(row[9]), "the same");
  }
  EXPECT_THAT(std::get<std::string>(sections.at(0).blocks.at(0)), HasSubstr("0 of 10"));
}

TEST(Against, ALinkThatGrewIsNamedWithItsSign) {
  session::Session session = session::read_bundle(kSessions + "00");
  const studies::CalibrationResult before = calibrated(session);
  studies::CalibrationResult after = before;
  constexpr double kGrowth_mm = 5.0;  // many times the parameter's uncertainty
  after.parameters.at(geometry::kL12).identified += kGrowth_mm;
  session::Session later = session;
  later.name = "later";
  for (session::Sample& sample : later.samples) {
    if (sample.time_utc) *sample.time_utc += std::chrono::hours(24);
  }
  // Which one is asked for does not change what is as found and what as left.
  for (const bool ask_later : {true, false}) {
    const report::Calibrated a{before, session};
    const report::Calibrated b{after, later};
    const auto sections =
        ask_later ? report::against_sections(b, a) : report::against_sections(a, b);
    const report::Table& t = table_of(sections.at(0), "against_parameters");
    EXPECT_NEAR(value(t.rows[geometry::kL12][6]), kGrowth_mm, 1e-9);  // mm, of one addition
    EXPECT_EQ(std::get<std::string>(t.rows[geometry::kL12][9]), "changed");
    EXPECT_THAT(std::get<std::string>(sections.at(0).blocks.at(0)), HasSubstr("1 of 10"));
    EXPECT_THAT(
        std::get<std::string>(table_of(sections.at(0), "against_errors").rows[0][0]),
        HasSubstr(session.name));
  }
}

TEST(Against, AResultThatIsNoCalibrationIsRefused) {
  const Json nothing{{"schema", "something.else"}};
  EXPECT_THROW(static_cast<void>(report::calibration_from_json(nothing)), studies::StudyError);
}

TEST(ReportCommand, PrintsAPdfAndShowsTwoSessionsBelowAMegabyte) {
  TempDirectory directory;
  const auto folder = directory.path() / "report";
  const auto pdf = directory.path() / "with space.pdf";
  std::string err;
  ASSERT_EQ(
      sixdial(
          {"report", kSessions + "00", "--against", kSessions + "01", "-q", "-o",
           folder.string(), "--pdf", pdf.string()},
          err),
      0)
      << err;
  const std::string page = read(folder / "report.html");
  EXPECT_LT(page.size(), 1'000'000U);
  EXPECT_THAT(page, HasSubstr("As found and as left"));
  EXPECT_THAT(page, HasSubstr("<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"rig\""));
  const std::string printed = read(pdf);
  EXPECT_TRUE(printed.starts_with("%PDF-"));
  EXPECT_THAT(printed, HasSubstr("/MediaBox [0 0 594.95996 841.91998]"));  // A4 in points
}

/// Sheets of paper that a page takes.
long pages_of(const std::filesystem::path& pdf) {
  const std::string printed = read(pdf);
  long pages = 0;
  constexpr std::string_view kPage = "/Type /Page\n";
  for (std::size_t at = printed.find(kPage); at != std::string::npos;
       at = printed.find(kPage, at + 1)) {
    ++pages;
  }
  return pages;
}

TEST(ReportCommand, IsSixPagesAndAnAnnex) {
  // Causes and gross readings: as much as a report has to say.
  TempDirectory directory;
  const auto folder = directory.path() / "report";
  const auto pdf = directory.path() / "front.pdf";
  std::string err;
  ASSERT_EQ(
      sixdial({"report", kSessions + "17", "--diagnose", "-q", "-o", folder.string()}, err), 0)
      << err;
  std::string page = read(folder / "report.html");
  EXPECT_THAT(page, HasSubstr("id=\"cause_3\""));
  const std::size_t annex = page.find("<div class=\"annex\"");
  ASSERT_NE(annex, std::string::npos);
  page.erase(annex, page.find("</main>") - annex);
  std::ofstream(folder / "front.html") << page;
  service::print_pdf(folder / "front.html", pdf);
  EXPECT_GE(pages_of(pdf), 3);
  EXPECT_LE(pages_of(pdf), 6);
}

TEST(ReportCommand, WithoutABrowserItSaysWhatToDo) {
  TempDirectory directory;
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", directory.path().c_str(), 1);
  std::string err;
  const int code = sixdial(
      {"report", kSessions + "00", "-q", "-o", (directory.path() / "r").string(), "--pdf",
       (directory.path() / "r.pdf").string()},
      err);
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(code, 1);
  EXPECT_THAT(err, HasSubstr("apt-get install chromium"));
  EXPECT_TRUE(std::filesystem::exists(directory.path() / "r" / "report.html"));
  EXPECT_FALSE(std::filesystem::exists(directory.path() / "r.pdf"));
}

}  // namespace
}  // namespace sixdial::cli
