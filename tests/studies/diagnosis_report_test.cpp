// The verdict on a page: a section for each cause, its picture, and what is read first.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "report/documents/diagnosis_json.h"
#include "report/report_run.h"
#include "report/sections/sections_of_studies.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/diagnose.h"
#include "tests/studies/diagnosis_parts.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> section_ids(const std::vector<report::Section>& sections) {
  std::vector<std::string> ids;
  for (const report::Section& section : sections) ids.push_back(section.id);
  return ids;
}

const report::Figure* figure_in(const report::Section& section, const std::string& id) {
  for (const report::Block& block : section.blocks) {
    const auto* figure = std::get_if<report::Figure>(&block);
    if (figure != nullptr && figure->id == id) return figure;
  }
  return nullptr;
}

TEST(DiagnosisReport, HasASectionForEachCauseWithItsSignature) {
  const Json document = Json::parse(quick(session_of("16")).dump());
  const auto sections = report::diagnosis_sections(report::diagnosis_from_json(document));
  EXPECT_THAT(
      section_ids(sections), ::testing::ElementsAre(
                                 "diagnosis", "cause_1", "cause_2", "left", "gain",
                                 "moved_parameters", "not_testable", "detection_limits"));
  for (const std::size_t i : {1U, 2U}) {
    const report::Figure* figure = figure_in(sections[i], "signature");
    ASSERT_NE(figure, nullptr) << sections[i].heading;
    for (const std::string& words : {figure->shows, figure->good, figure->here}) {
      EXPECT_FALSE(words.empty());
    }
    EXPECT_GT(figure->table.rows.size(), 100U);
  }
  EXPECT_NE(figure_in(sections[3], "left_by_covariate"), nullptr);
  EXPECT_NE(figure_in(sections[3], "tool_shift"), nullptr);
}

TEST(DiagnosisReport, ABacklashShowsAsTwoLevelsItsWidthApart) {
  const Json document = quick(session_of("01"));
  const Json& cause = cause_of(document, "joint_backlash@joint2");
  const Json& groups = cause["signature_plot"]["panels"][0]["groups"];
  ASSERT_EQ(groups.size(), 2U);
  const auto mean = [](const Json& values) {
    double sum = 0.0;
    for (const Json& each : values) sum += each.get<double>();
    return sum / static_cast<double>(values.size());
  };
  constexpr double kDeg = 57.29577951308232;
  const double width_deg = kDeg * std::abs(cause["estimate"][0]["value"].get<double>());
  const double apart = std::abs(mean(groups[0]["measured"]) - mean(groups[1]["measured"]));
  // 75 points a level, each known to a few hundredths of the width.
  EXPECT_LT(std::abs(apart - width_deg), 0.05 * width_deg);
}

TEST(DiagnosisReport, APageSaysFirstWhatAMetrologistNeeds) {
  const session::Session session = session_of("02");
  DiagnosisRequest request;
  request.bootstrap = 20;
  const std::string page =
      report::diagnosis_page(diagnose(session, request), session, "tester");
  EXPECT_LT(page.size(), 1'000'000U);
  const std::string box = page.substr(page.find("id=\"state\""));
  const std::string first = box.substr(0, box.find("</section>"));
  for (const char* words :
       {"Thermal growth of the links", "confirmed", "What to do", "What could not be judged",
        "falls from", "(ANFIS)", "noise"}) {
    EXPECT_THAT(first, HasSubstr(words));
  }
  EXPECT_THAT(page, HasSubstr("A network on joint angles cannot learn this"));
  EXPECT_THAT(page, HasSubstr("id=\"cause_1\""));
  EXPECT_THAT(page, ::testing::Not(HasSubstr("No calibration result is stored")));
}

}  // namespace
}  // namespace sixdial::studies
