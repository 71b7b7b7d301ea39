// The report in a real browser (Debian's chromium, headless): charts drawn, console silent,
// nothing lost without JavaScript, prints to A4.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "arm_report.h"
#include "report/html_report.h"
#include "report/tables.h"
#include "report/text.h"
#include "run_program.h"
#include "sample_session.h"
#include "tests/support/paths.h"

namespace sixdial::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr int kPanels =
    3 + 2 + 3 + 2 + 10;  // maps, error by set, what is left by angle ..., swarms, parameters

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size())
    ++n;
  return n;
}

class Browser : public testing::Test {
 protected:
  void SetUp() override {
    const Ran ran = run_program("chromium --version");
    ASSERT_EQ(ran.exit_code, 0) << "This test needs a browser: apt-get install chromium\n"
                                << ran.err;
  }

  Ran open(const std::string& page, const std::string& options) const {
    const std::string file = folder_.write("page.html", page);
    return run_program(fmt::format(
        "exec chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
        "--disable-background-networking --disable-sync --no-first-run --disable-extensions "
        "--enable-logging=stderr --user-data-dir={0}/profile {1} file://{2}",
        folder_.path().string(), options, file));
  }
  [[nodiscard]] std::string dom(
      const std::string& page, const std::string& options = "") const {
    const Ran ran = open(page, "--dump-dom " + options);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_EQ(count(ran.err, "CONSOLE"), 0) << "the browser complained:\n" << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("</html>"));
    return ran.out;
  }

  /// What tests/report/browser.py saw: requests, complaints, dom, text.
  [[nodiscard]] json look(const std::string& page, const std::string& options = "") const {
    const Ran ran = run_program(fmt::format(
        "python3 {}/tests/report/browser.py {} {}", test_paths::source_dir(), options,
        folder_.write("page.html", page)));
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    json out = json::parse(ran.out, nullptr, false);
    EXPECT_FALSE(out.is_discarded());
    return out;
  }

  TemporaryFolder folder_;
};

TEST_F(Browser, AComplaintOnTheConsoleWouldBeSeen) {
  const Ran ran =
      open("<!doctype html><title>t</title><script>no_such_function()</script>", "--dump-dom");
  EXPECT_GT(count(ran.err, "CONSOLE"), 0) << ran.err;
}

TEST_F(Browser, DrawsEveryChart) {
  ASSERT_TRUE(has_chart_libraries()) << "built without npm: there are no charts to draw";
  const std::string page = dom(html_report(sample_session()));
  EXPECT_EQ(count(page, "data-drawn=\"yes\""), 5);
  EXPECT_EQ(count(page, "data-drawn=\"no\""), 0);
  EXPECT_EQ(count(page, "<svg class=\"plot\""), kPanels);
  EXPECT_EQ(count(page, "NaN"), count(html_report(sample_session()), "NaN"));  // no broken path
  EXPECT_EQ(count(page, "<canvas"), 0);
  EXPECT_EQ(count(page, "<details open"), 0);  // folded where a chart was drawn
}

TEST_F(Browser, ShowsTablesWithoutJavaScript) {
  const json seen = look(html_report(sample_session()), "--no-script");
  const std::string page = seen["dom"];
  EXPECT_EQ(count(page, "data-drawn"), 0);  // no script ran
  EXPECT_EQ(count(page, "<svg"), 0);
  EXPECT_EQ(count(page, "<details open"), 5);
  // What is laid out, not what the file says: every cell of the figures' tables is seen.
  const auto texts = seen["text"].get<std::vector<std::string>>();
  const std::set<std::string> shown_texts{texts.begin(), texts.end()};
  const ReportData data = sample_session();
  int found = 0;
  for (const Table& table :
       {residual_table(data), error_table(data), convergence_table(data, true),
        parameter_table(data, false), accuracy_table(data, false)}) {
    for (const auto& row : table.rows) {
      for (const Cell& cell : row) {
        ASSERT_EQ(shown_texts.count(shown(cell)), 1U) << table.id << ": " << shown(cell);
        ++found;
      }
    }
  }
  EXPECT_GT(found, 2000);
}

TEST_F(Browser, DrawsAnArmFromThreeSides) {
  ASSERT_TRUE(has_chart_libraries()) << "built without npm: there are no charts to draw";
  const std::string page = html_report(arm_report());
  const std::string drawn = dom(page);
  EXPECT_EQ(count(drawn, "data-drawn=\"no\""), 0);
  for (const char* from : {"from above", "from the front", "from the side"}) {
    EXPECT_EQ(count(drawn, fmt::format("{}<span>", from)), 2) << from;  // before and after
  }
  const json seen = look(page, "--no-script");
  EXPECT_EQ(count(seen["dom"], "<svg class=\"plot\""), 0);
  for (const char* words : {"measured at", "from the front (x, z)"}) {
    EXPECT_THAT(seen["text"].dump(), HasSubstr(words));
  }
}

TEST_F(Browser, AsksForNothingButThePage) {
  const json seen = look(html_report(sample_session()));
  EXPECT_EQ(seen["requests"].size(), 1U) << seen["requests"];
  EXPECT_EQ(seen["complaints"].size(), 0U) << seen["complaints"];
  EXPECT_EQ(count(seen["dom"], "<svg class=\"plot\""), has_chart_libraries() ? kPanels : 0);
}

TEST_F(Browser, AForbiddenRequestWouldBeSeen) {
  std::string page = html_report(sample_session({.g1_points = 12, .g2_points = 6}));
  page.replace(page.find("<main>"), 6, "<main><img src=\"http://127.0.0.1:9/x.png\">");
  const json seen = look(page);
  EXPECT_GT(seen["complaints"].size(), 0U);  // the page's own policy forbids it
}

TEST_F(Browser, HostileTextRunsNothing) {
  ReportData data = sample_session({.g1_points = 12, .g2_points = 6});
  const std::string hostile =
      R"(</script><script>document.title='taken'</script><img src=x onerror="document.title='taken'">)";
  data.head.session_name = hostile;
  data.methods[1].name = hostile;
  data.convergence[0].name = hostile;
  const std::string page = dom(html_report(data));
  EXPECT_THAT(page, Not(HasSubstr("<title>taken")));
  EXPECT_EQ(count(page, "<img"), 0);
  EXPECT_EQ(count(page, "data-drawn=\"yes\""), has_chart_libraries() ? 5 : 0);
}

TEST_F(Browser, DrawsALargeSessionAndAnEmptyOne) {
  const std::string large =
      dom(html_report(sample_session({.g1_points = 3000, .g2_points = 500})));
  EXPECT_EQ(count(large, "data-drawn=\"no\""), 0);
  const std::string empty = dom(html_report(ReportData{}));
  EXPECT_THAT(empty, HasSubstr("Not calibrated"));
}

TEST_F(Browser, AChartThatFailsSaysSoAndKeepsItsTable) {
  ASSERT_TRUE(has_chart_libraries()) << "built without npm: there are no charts to draw";
  std::string page = html_report(sample_session({.g1_points = 12, .g2_points = 6}));
  const std::string good = "\"mark\":\"arrows\"";
  for (std::size_t at; (at = page.find(good)) != std::string::npos;) {
    page.replace(at, good.size(), "\"mark\":\"wrong!\"");
  }
  const std::string drawn = dom(page);
  EXPECT_EQ(count(drawn, "data-drawn=\"no\""), 1);
  EXPECT_EQ(count(drawn, "data-drawn=\"yes\""), 4);
  EXPECT_EQ(count(drawn, "<details open"), 1);
  EXPECT_THAT(drawn, HasSubstr("could not be drawn"));
}

TEST_F(Browser, PrintsToA4) {
  const std::string pdf = (folder_.path() / "report.pdf").string();
  const Ran ran = open(
      html_report(sample_session()),
      fmt::format("--no-pdf-header-footer --print-to-pdf={}", pdf));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  std::ifstream file{pdf, std::ios::binary};
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str().substr(0, 5), "%PDF-");
  const int pages = count(text.str(), "/Type /Page\n");
  EXPECT_GE(pages, 5);
  EXPECT_LE(pages, 14);  // figures' tables are folded; 150 points take three pages
  EXPECT_GE(count(text.str(), "/MediaBox [0 0 594.95996 841.91998]"), 1);  // A4 in points
}

}  // namespace
}  // namespace sixdial::report
