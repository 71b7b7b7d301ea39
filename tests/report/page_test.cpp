// The page: well-formed, self-contained, complete, and not to be broken by what people type.
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
using testing::Not;

constexpr std::size_t kLargestPage = 1'000'000;  // bytes: spec 6, "under 1 MB"
const std::string kHostile =
    R"x(</script><script>alert(1)</script><img src=x onerror="alert(2)">'&amp;)x"
    "\xFF\x01";

/// The sample session with the hostile text in every place that a text can come from.
ReportData hostile_session() {
  ReportData data = sample_session({.g1_points = 12, .g2_points = 6});
  Head& h = data.head;
  for (std::string* text :
       {&h.title, &h.session_name, &h.rig_name, &h.robot, &h.operator_name, &h.place,
        &h.measured_from, &h.measured_to, &h.reported, &h.software_version, &h.data_hash,
        &h.rig_hash, &h.profile}) {
    *text = kHostile;
  }
  h.settings.emplace_back(kHostile, kHostile);
  h.instruments.push_back(
      {.id = kHostile, .description = kHostile, .serial = kHostile, .connection = kHostile});
  data.methods[1].id = kHostile;
  data.methods[1].name = kHostile;
  data.parameters[0].name = kHostile;
  data.parameters[0].unit = kHostile;
  data.correlations.push_back({kHostile, kHostile, 0.95});
  data.unidentifiable.push_back(kHostile);
  data.points[0].dials = kHostile;
  data.points[1].set = kHostile;
  data.rejected.push_back({.line = 1, .text = {}, .reason = kHostile});
  data.bad_readings.push_back({.set = kHostile, .dial = kHostile, .reason = kHostile});
  data.facts.stand_out.push_back({.set = kHostile, .dial = kHostile, .remark = kHostile});
  data.convergence[0].name = kHostile;
  data.traces[0].name = kHostile;
  data.traces[0].step = kHostile;
  Table table{.id = "hostile_table", .caption = kHostile};
  table.columns = {{kHostile, kHostile, kHostile, kHostile}};
  table.rows = {{kHostile}};
  table.notes = {kHostile};
  Figure figure{
      .id = "hostile\"figure", .title = kHostile, .shows = kHostile, .good = kHostile};
  figure.here = kHostile;
  figure.table = table;
  figure.table.id = "hostile_figure_table";
  Series series{.name = kHostile, .x = {1, 2}, .y = {1, 2}, .label = kHostile};
  figure.chart.panels = {{.title = kHostile, .x = {.label = kHostile, .unit = kHostile}}};
  figure.chart.panels[0].series = {series};
  data.sections.push_back(
      {.id = "hostile", .heading = kHostile, .blocks = {kHostile, table, figure}});
  return data;
}

TEST(Page, IsWellFormed) {
  const json page = tables_of(html_report(sample_session()));
  EXPECT_EQ(page["counts"]["figure"], 5);
  EXPECT_EQ(page["counts"]["figcaption"], 5);
  EXPECT_EQ(page["counts"]["details"], 5);
}

TEST(Page, IsWellFormedForEmptyAndSmallSessions) {
  tables_of(html_report(ReportData{}));
  ReportData data = sample_session({.g1_points = 12, .g2_points = 0});
  tables_of(html_report(data));
  data.methods.resize(1);
  tables_of(html_report(data));
  data.points.resize(1);
  tables_of(html_report(data));
}

TEST(Page, ReferencesNothingOutsideItself) {
  std::string page = html_report(sample_session());
  // What the chart libraries name without ever asking for it: XML namespaces, their own home
  // page.
  for (const char* named : {"http://www.w3.org/", "https://d3js.org v7.9.0"}) {
    for (std::size_t at; (at = page.find(named)) != std::string::npos;) {
      page.erase(at, std::string_view{named}.size());
    }
  }
  EXPECT_THAT(page, Not(HasSubstr("http://")));
  EXPECT_THAT(page, Not(HasSubstr("https://")));
  std::string markup = without_scripts(page);
  const std::string to_itself = "href=\"#";
  for (std::size_t at; (at = markup.find(to_itself)) != std::string::npos;) {
    markup.erase(at, to_itself.size());
  }
  for (const char* reference :
       {"src=", "href=", "url(", "@import", "<link", "<iframe", "<img"}) {
    EXPECT_THAT(markup, Not(HasSubstr(reference)));
  }
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

TEST(Page, IsUnderAMegabyteForAnySession) {
  EXPECT_LT(html_report(sample_session()).size(), kLargestPage);
  const ReportData large = sample_session({.g1_points = 6000, .g2_points = 4000});
  const std::string page = html_report(large);
  EXPECT_LT(page.size(), kLargestPage);
  EXPECT_THAT(page, HasSubstr("of 10000 rows"));
  EXPECT_THAT(page, HasSubstr("an even choice of each series"));
  EXPECT_EQ(read_csv(csv_file(csv_report(large), "points.csv")).size(), 10001U);
}

TEST(Page, IsUnderAMegabyteWithManyCharts) {
  // A diagnosis of a long session has a chart for each of its causes.
  ReportData large = sample_session({.g1_points = 1500, .g2_points = 500});
  Figure figure{.id = "signature", .title = "signature"};
  Series series{.name = "points", .mark = Mark::kDots};
  for (int i = 0; i < 6000; ++i) {
    series.x.push_back(i + 0.123456);
    series.y.push_back(0.00123456 * i);
  }
  figure.chart.panels.push_back({.title = "one", .series = {series}});
  Section section{.id = "causes", .heading = "Causes"};
  for (int i = 0; i < 12; ++i) section.blocks.emplace_back(figure);
  large.sections.push_back(section);
  const std::string page = html_report(large);
  EXPECT_LT(page.size(), kLargestPage);
  std::vector<const Chart*> charts(12, &figure.chart);
  EXPECT_LE(12 * marks_allowed(charts), kMarksOnPage);
  EXPECT_EQ(marks_allowed({&figure.chart}), kMarksOnChart);  // alone it may have them all
}

TEST(Page, CarriesItsLibrariesOnceOrSaysThatItHasNone) {
  const std::string page = html_report(sample_session());
  const std::string plain = html_report(sample_session(), {.charts = false});
  EXPECT_THAT(plain, HasSubstr("id=\"no_charts\""));
  EXPECT_THAT(plain, Not(HasSubstr("<script")));
  EXPECT_THAT(plain, Not(HasSubstr("data-chart")));
  if (has_chart_libraries()) {
    const std::string mark = "// @observablehq/plot v0.6.17";
    const std::size_t first = page.find(mark);
    ASSERT_NE(first, std::string::npos);
    EXPECT_EQ(page.find(mark, first + 1), std::string::npos);
    EXPECT_THAT(page, HasSubstr("Permission to use, copy, modify"));  // the licence goes along
    EXPECT_THAT(page, Not(HasSubstr("id=\"no_charts\"")));
  } else {
    EXPECT_THAT(page, HasSubstr("id=\"no_charts\""));
  }
}

TEST(Page, SaysThatItIsNoAccreditedCertificate) {
  const std::string page = html_report(sample_session(), {.charts = false});
  const std::size_t body = page.find("<body>");
  EXPECT_LT(
      page.find("Not an accredited certificate", body), page.find("State of the robot", body));
}

TEST(Page, TellsTheStateBeforeAnySection) {
  const std::string page = without_scripts(html_report(sample_session()));
  const std::size_t state = page.find("State of the robot");
  EXPECT_LT(state, page.find("Accuracy before and after"));
  EXPECT_LT(state, page.find("Identified parameters"));
}

/// A page that is not about a calibration, hostile in every text of its first box.
ReportData opened_session() {
  ReportData data = sample_session({.g1_points = 12, .g2_points = 6});
  data.methods.clear();
  data.opening = Opening{
      .subject = "Diagnosis",
      .title = "Backlash of joint 2",
      .mood = "open",
      .headline = "Found at once.",
      .before_mm = 0.0123,
      .after_mm = 0.0016,
      .basis = "mean position error"};
  data.opening->lists = {
      {"Found", "to_do", {"one cause"}},
      {"What to do", "to_do", {kHostile}},
      {"How sure", "cautions", {"quite"}},
      {"What could not be judged", "not_judged", {"nothing"}}};
  data.sections = {{.id = "cause_1", .heading = "Backlash of joint 2", .blocks = {"words"}}};
  return data;
}

TEST(Page, OpensWithAnotherSubjectWhereItIsNotAboutACalibration) {
  const std::string page = html_report(opened_session());
  EXPECT_FALSE(tables_of(page).is_discarded());
  const std::string box = page.substr(page.find("id=\"state\""));
  const std::string first = box.substr(0, box.find("</section>"));
  for (const char* words :
       {"Diagnosis: ", "Backlash of joint 2", "0.0123", "0.0016", "Found at once.", "one cause",
        "How sure", "What could not be judged"}) {
    EXPECT_THAT(first, HasSubstr(words));
  }
  EXPECT_THAT(without_scripts(page), Not(HasSubstr("<img src=x")));
  EXPECT_THAT(page, HasSubstr("id=\"cause_1\""));
  EXPECT_THAT(page, HasSubstr("id=\"conditions\""));
  for (const char* left_out :
       {"State of the robot: ", "id=\"accuracy\"", "id=\"parameters\""}) {
    EXPECT_THAT(page, Not(HasSubstr(left_out)));
  }
}

TEST(Page, ShowsWhatElseIsSaidBelowTheStateOfTheRobot) {
  ReportData data = sample_session({.g1_points = 12, .g2_points = 6});
  data.also.push_back(
      {"What the simulation gets wrong", "cautions", {"Backlash of joint 2: 0.02\u00B0"}});
  const std::string page = html_report(data);
  const std::string box = page.substr(page.find("id=\"state\""));
  const std::string first = box.substr(0, box.find("</section>"));
  EXPECT_THAT(first, HasSubstr("State of the robot"));
  EXPECT_THAT(first, HasSubstr("What the simulation gets wrong"));
  EXPECT_THAT(first, HasSubstr("Backlash of joint 2: 0.02"));
}

TEST(Page, HasEveryNumberOfEveryTable) {
  const ReportData data = sample_session();
  const json page = tables_of(html_report(data));
  int compared = 0;
  for (const Table& table :
       {accuracy_table(data, false), confidence_table(data), parameter_table(data, false),
        residual_table(data), error_table(data), worst_points_table(data, 8),
        measurement_table(data), convergence_table(data, true)}) {
    const json& rows = page["tables"][table.id]["rows"];
    ASSERT_EQ(rows.size(), table.rows.size()) << table.id;
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        ASSERT_EQ(rows[r][c], shown(table.rows[r][c])) << table.id << " row " << r;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 3000);
}

/// Table 6 of Cao et al. 2021, as printed [mm]: mean, std, max of G1, then of G2.
struct PaperRow {
  const char* id;
  const char* name;
  std::array<double, 6> mm;
};
constexpr std::array<PaperRow, 5> kPaperTable6{{
    {"before", "Before calibration", {3.051, 0.177, 3.367, 2.995, 0.179, 3.452}},
    {"lse+bpnn", "LSE & BPNN", {0.040, 0.021, 0.078, 0.049, 0.024, 0.091}},
    {"ekf+bpnn", "EKF & BPNN", {0.032, 0.019, 0.061, 0.039, 0.021, 0.076}},
    {"ekf_dqpso", "EKF-DQPSO", {0.034, 0.018, 0.056, 0.038, 0.019, 0.063}},
    {"ekf_dqpso+anfis", "EKF-DQPSO & ANFIS", {0.018, 0.012, 0.032, 0.022, 0.013, 0.038}},
}};

TEST(Page, ShowsThePapersTablesAsThePaperDoes) {
  ReportData data;
  for (const PaperRow& row : kPaperTable6) {
    const auto& m = row.mm;
    data.methods.push_back(
        {.id = row.id,
         .name = row.name,
         .g1 = ErrorStatistics{.mean_mm = m[0], .std_mm = m[1], .max_mm = m[2], .points = 100},
         .g2 = ErrorStatistics{.mean_mm = m[3], .std_mm = m[4], .max_mm = m[5], .points = 50}});
  }
  data.parameters = parameter_rows(
      *geometry::five_bar_model(), geometry::default_rig().robot.nominal,
      geometry::table_2_robot(), std::nullopt);
  const json page = tables_of(html_report(data))["tables"];
  const json report = json::parse(json_report(data));
  const auto csv = read_csv(csv_file(csv_report(data), "table6.csv"));
  for (std::size_t r = 0; r < kPaperTable6.size(); ++r) {
    EXPECT_EQ(page["table6"]["rows"][r][0], kPaperTable6[r].name);
    EXPECT_EQ(csv[r + 1][0], kPaperTable6[r].id);
    std::size_t c = 1;
    for (const double value : kPaperTable6[r].mm) {
      EXPECT_EQ(page["table6"]["rows"][r][c++], fixed(value, 4));
    }
    EXPECT_EQ(report["table6"][r]["g1_std_mm"], kPaperTable6[r].mm[1]);
    EXPECT_EQ(report["table6"][r]["g2_max_mm"], kPaperTable6[r].mm[5]);
  }
  EXPECT_EQ(page["table6"]["head"][0][1], "G1 calibration, 100 points");
  EXPECT_EQ(page["table6"]["head"][0][2], "G2 validation, 50 points");
  // Table 2, as printed; angles in degrees.
  const std::array<const char*, 10> identified{"59.742", "60.483", "60.341", "59.704",
                                               "89.511", "0.851",  "-0.556", "0.148",
                                               "-0.873", "-1.032"};
  for (std::size_t r = 0; r < identified.size(); ++r) {
    EXPECT_EQ(page["table2"]["rows"][r][4], identified[r]);
    EXPECT_EQ(page["table2"]["rows"][r][2], r < 7 ? "mm" : "deg");
    EXPECT_TRUE(report["table2"][r]["sd"].is_null());
  }
}

TEST(Page, ParametersCarryTheirUncertaintyInShownUnits) {
  geometry::ParameterMatrix covariance = geometry::ParameterMatrix::Zero();
  covariance.diagonal().setConstant(1e-6);  // sd 0.001 mm or 0.001 rad
  std::vector<bool> held(10, false);
  held[4] = true;
  const auto rows = parameter_rows(
      *geometry::five_bar_model(), geometry::default_rig().robot.nominal,
      geometry::table_2_robot(), covariance, held);
  ASSERT_EQ(rows.size(), 10U);
  constexpr double kExact = 1e-12;  // a few flops on values of order 60
  EXPECT_NEAR(*rows[0].sd, 0.001, kExact);
  EXPECT_NEAR(*rows[0].low, 59.742 - 1.959963984540054 * 0.001, kExact);
  EXPECT_NEAR(*rows[7].sd, 0.0572957795130823, kExact);  // 0.001 rad in degrees
  EXPECT_NEAR(*rows[7].high - *rows[7].low, 2 * 1.959963984540054 * 0.0572957795130823, kExact);
  EXPECT_TRUE(rows[4].held);
  EXPECT_FALSE(rows[4].sd.has_value());
}

TEST(Page, StatisticsAreThoseOfTheErrors) {
  ReportData data;
  data.methods = {{.id = "before", .name = "Before"}};
  for (const double error : {3.0, 4.0, 8.0}) {
    PointRow row{.set = "G2"};
    row.residual_mm = {Eigen::Vector2d{0.6 * error, -0.8 * error}};
    data.points.push_back(row);
  }
  data.points.push_back({.set = "G2"});  // gave no position
  const auto found = error_statistics(data, "G2", 0);
  ASSERT_TRUE(found);
  constexpr double kExact = 1e-12;  // a few flops on values of order 10
  EXPECT_EQ(found->points, 3);
  EXPECT_NEAR(found->mean_mm, 5.0, kExact);
  EXPECT_NEAR(found->std_mm, std::sqrt(7.0), kExact);  // (4 + 1 + 9) / 2
  EXPECT_NEAR(found->max_mm, 8.0, kExact);
  EXPECT_NEAR(
      *found->mean_high_mm - *found->mean_low_mm, 2 * 1.959963984540054 * std::sqrt(7.0 / 3.0),
      kExact);
  EXPECT_FALSE(error_statistics(data, "G1", 0).has_value());
  EXPECT_FALSE(error_statistics(data, "G2", 1).has_value());
}

TEST(Page, HostileTextStaysText) {
  const ReportData data = hostile_session();
  const std::string page = html_report(data);
  const json read = tables_of(page);
  EXPECT_EQ(read["counts"].count("img"), 0U);
  EXPECT_EQ(read["counts"]["script"], has_chart_libraries() ? 4 : 0);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_EQ(read["tables"]["hostile_table"]["rows"][0][0], valid_utf8(kHostile));
  const json report = json::parse(json_report(data));
  EXPECT_EQ(report["head"]["session"], valid_utf8(kHostile));
  EXPECT_EQ(
      report["sections"][0]["blocks"][1]["table"]["rows"][0].begin().value(),
      valid_utf8(kHostile));
  for (const CsvFile& file : csv_report(data)) {
    const auto rows = read_csv(file.text);
    for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size()) << file.name;
    EXPECT_EQ(
        file.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"),
        file.name.size() - std::string_view{".csv"}.size())
        << file.name;
  }
}

TEST(Page, NumbersThatAreNoneAreADashAndNull) {
  ReportData data = sample_session({.g1_points = 12, .g2_points = 6});
  data.methods[2].g2->max_mm = std::numeric_limits<double>::quiet_NaN();
  data.points[3].residual_mm[0]->x() = std::numeric_limits<double>::infinity();
  data.convergence[0].best_mm[0] = std::numeric_limits<double>::infinity();
  const json page = tables_of(html_report(data));
  EXPECT_EQ(page["tables"]["table6"]["rows"][2][6], "\u2013");
  const std::string text = json_report(data);
  EXPECT_TRUE(json::parse(text)["table6"][2]["g2_max_mm"].is_null());
  EXPECT_THAT(html_report(data, {.charts = false}), Not(HasSubstr(">nan<")));
  EXPECT_THAT(html_report(data, {.charts = false}), Not(HasSubstr(">inf<")));
}

}  // namespace
}  // namespace sixdial::report
