// Charts as the page draws them, and the libraries that do.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "geometry/rig.h"
#include "page_parts.h"
#include "report/chart_json.h"
#include "report/csv_report.h"
#include "report/html_report.h"
#include "report/json_report.h"
#include "report/tables.h"
#include "report/text.h"
#include "run_program.h"
#include "sample_session.h"
#include "tests/support/paths.h"

namespace sixdial::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(Chart, ThinsLongSeriesAndKeepsTheirEnds) {
  Series series;
  for (int i = 0; i < 12345; ++i) {
    series.x.push_back(i);
    series.y.push_back(2.0 * i);
  }
  Chart chart;
  chart.panels.emplace_back();
  chart.panels[0].series = {series};
  const std::size_t all = kMarksOnChart;
  EXPECT_TRUE(is_thinned(chart));
  const json drawn = chart_json(chart)["panels"][0]["series"][0];
  EXPECT_EQ(drawn["x"].size(), all);
  EXPECT_EQ(drawn["x"].front(), 0);
  EXPECT_EQ(drawn["x"].back(), 12344);
}

TEST(Chart, LeavesOutPointsThatAreNotFinite) {
  Chart chart;
  chart.panels.emplace_back();
  chart.panels[0].series = {
      {.x = {1, 2, 3}, .y = {1, std::numeric_limits<double>::quiet_NaN(), 3}}};
  const json drawn = chart_json(chart)["panels"][0]["series"][0];
  EXPECT_EQ(drawn["x"], (json{1.0, 3.0}));
  EXPECT_EQ(drawn["y"], (json{1.0, 3.0}));
}

TEST(ChartLibraries, TheLockNamesNoRegistry) {
  std::ifstream file{test_paths::source_dir() + "/report/web/package-lock.json"};
  std::stringstream lock;
  lock << file.rdbuf();
  EXPECT_THAT(lock.str(), HasSubstr("\"integrity\""));
  EXPECT_THAT(lock.str(), Not(HasSubstr("http")));
  EXPECT_THAT(lock.str(), Not(HasSubstr("\"resolved\"")));
}

TEST(ChartLibraries, WithoutNpmTheBuildGoesOn) {
  for (const std::string npm : {"", "/bin/false"}) {
    const TemporaryFolder folder;
    const std::string made = (folder.path() / "made.cpp").string();
    const Ran ran = run_program(fmt::format(
        "cmake -DWEB={0}/report/web -DWORK={1}/web -DNPM={2} -DHEADER=report/assets.h "
        "-DNAMESPACE=sixdial::report::assets -DOUTPUT={3} -P {0}/cmake/ChartLibraries.cmake",
        test_paths::source_dir(), folder.path().string(), npm, made));
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_THAT(ran.err, HasSubstr("tables only"));
    std::ifstream file{made};
    std::stringstream code;
    code << file.rdbuf();
    EXPECT_THAT(
        code.str(), HasSubstr("std::string_view plot_js() {\n  return R\"sixdial_text()"));
  }
}

}  // namespace
}  // namespace sixdial::report
