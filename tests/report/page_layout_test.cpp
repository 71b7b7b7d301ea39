// How a page is laid out: contents, annex, labelled figures, one look.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "geometry/rig.h"
#include "page_parts.h"
#include "report/figures.h"
#include "report/html_report.h"
#include "report/rig_picture.h"
#include "report/sections.h"
#include "sample_session.h"

namespace sixdial::report {
namespace {

using testing::HasSubstr;
using testing::Not;

/// What stands between `begin` and `end` after it, each time.
std::vector<std::string> between(
    const std::string& text, const std::string& begin, const std::string& end) {
  std::vector<std::string> out;
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    at += begin.size();
    out.push_back(text.substr(at, text.find(end, at) - at));
  }
  return out;
}

TEST(PageLayout, ListsItsSectionsAndPutsDetailsIntoAnAnnex) {
  ReportData data = sample_session();
  data.sections.push_back({.id = "parameters", .heading = "Twin", .in_annex = true});
  data.sections.push_back({.id = "causes", .heading = "Causes", .blocks = {"words"}});
  const std::string page = without_scripts(html_report(data));
  const auto targets = between(page, "href=\"#", "\"");
  const auto ids = between(page, "<section id=\"", "\"");
  std::vector<std::string> wanted;
  for (const std::string& each : targets) {
    if (each != "annex") wanted.push_back(each);
  }
  EXPECT_EQ(wanted, ids);  // every section in order, each under an id of its own
  EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), ids.size());
  const std::size_t annex = page.find("id=\"annex\"");
  ASSERT_NE(annex, std::string::npos);
  for (const char* needed : {"accuracy", "parameters", "causes", "data", "conditions"}) {
    EXPECT_LT(page.find(fmt::format("<section id=\"{}\"", needed)), annex) << needed;
  }
  for (const char* detail :
       {"accuracy_details", "identification", "made_from", "settings", "positions",
        "parameters_2"}) {
    const std::size_t at = page.find(fmt::format("<section id=\"{}\"", detail));
    EXPECT_NE(at, std::string::npos) << detail;
    EXPECT_GT(at, annex) << detail;
  }
}

TEST(PageLayout, EveryFigureHasANumberATitleAndLabelledAxes) {
  ReportData data = sample_session();
  data.sections.push_back(rig_section(geometry::default_rig()));
  const std::string page = html_report(data);
  const auto captions = between(page, "<p class=\"figure-title\"><b>Figure ", "</p>");
  ASSERT_EQ(captions.size(), between(page, "<figure", ">").size());
  for (std::size_t i = 0; i < captions.size(); ++i) {
    EXPECT_EQ(captions[i].find(fmt::format("{}</b> ", i + 1)), 0U) << captions[i];
    EXPECT_GT(captions[i].size(), std::string("10</b> ").size() + 2);
  }
  for (const Section& section : sections_of(data)) {
    for (const Block& block : section.blocks) {
      const auto* figure = std::get_if<Figure>(&block);
      if (figure == nullptr) continue;
      for (const Panel& panel : figure->chart.panels) {
        EXPECT_FALSE(panel.x.label.empty()) << figure->id;
        EXPECT_FALSE(panel.y.label.empty()) << figure->id;
      }
    }
  }
}

// A swarm that only has nanometres left to go is drawn as the level line that it is.
TEST(PageLayout, AnAxisOfErrorsShowsAtLeastTheStepOfADial) {
  ReportData data;
  data.convergence = {{.name = "QPSO-2", .best_mm = {0.016806, 0.016798, 0.016790}}};
  data.least_squares_rmse_mm = 0.016790;
  const auto figure = convergence(data);
  ASSERT_TRUE(figure);
  const Axis& axis = figure->chart.panels.at(0).y;
  ASSERT_TRUE(axis.low && axis.high);
  EXPECT_GE(*axis.high - *axis.low, 0.001);
  EXPECT_LT(*axis.low, 0.016790);
  EXPECT_GT(*axis.high, 0.016806);
  data.convergence[0].best_mm = {0.030, 0.020, 0.0168};  // has far to go: its own scale
  EXPECT_FALSE(convergence(data)->chart.panels.at(0).y.low);
}

TEST(PageLayout, HasOneLookForPaperAndForEveryScreen) {
  const std::string page = html_report(sample_session());
  EXPECT_THAT(page, HasSubstr("<meta name=\"color-scheme\" content=\"only light\">"));
  EXPECT_THAT(page, Not(HasSubstr("prefers-color-scheme")));
}

}  // namespace
}  // namespace sixdial::report
