// The JSON and the CSV files of a report say what its page says.
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

TEST(Page, JsonAndCsvAgreeWithItsTableSix) {
  const ReportData data = sample_session();
  const json page = tables_of(html_report(data));
  const json report = json::parse(json_report(data));
  const auto csv = read_csv(csv_file(csv_report(data), "table6.csv"));
  const json& rows = page["tables"]["table6"]["rows"];
  ASSERT_EQ(rows.size(), 3U);
  ASSERT_EQ(csv.size(), 4U);
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_EQ(rows[r][0], report["table6"][r]["name"]);
    std::size_t column = 1;
    for (const std::string key :
         {"g1_mean_mm", "g1_std_mm", "g1_max_mm", "g2_mean_mm", "g2_std_mm", "g2_max_mm"}) {
      const double value = report["table6"][r][key].get<double>();
      EXPECT_EQ(rows[r][column], fixed(value, 4)) << key;
      const auto at = std::find(csv[0].begin(), csv[0].end(), key) - csv[0].begin();
      EXPECT_EQ(std::stod(csv[r + 1][static_cast<std::size_t>(at)]), value) << key;
      ++column;
    }
  }
}

TEST(Page, JsonAndCsvAgreeWithItsParameters) {
  const ReportData data = sample_session();
  const json rows = tables_of(html_report(data))["tables"]["table2"]["rows"];
  const json table2 = json::parse(json_report(data))["table2"];
  const auto csv = read_csv(csv_file(csv_report(data), "table2.csv"));
  ASSERT_EQ(table2.size(), 10U);
  for (std::size_t r = 0; r < 10; ++r) {
    const double identified = table2[r]["identified"].get<double>();
    EXPECT_EQ(identified, data.parameters[r].identified);
    EXPECT_EQ(std::stod(csv[r + 1][3]), identified);
    const std::string text = rows[r][4].get<std::string>();
    const std::size_t decimals = text.size() - text.find('.') - 1;
    EXPECT_EQ(text, fixed(identified, static_cast<int>(decimals)));
    EXPECT_GE(decimals, 3U);
  }
  EXPECT_EQ(table2[0]["parameter"], "l11");
  EXPECT_EQ(table2[7]["unit"], "deg");
}

TEST(Page, JsonAndCsvAgreeOnEveryPoint) {
  const ReportData data = sample_session();
  const json points = json::parse(json_report(data))["points"];
  const auto csv = read_csv(csv_file(csv_report(data), "points.csv"));
  ASSERT_EQ(points.size(), 150U);
  ASSERT_EQ(csv.size(), 151U);
  const auto column = [&](const std::string& key) {
    const auto found = std::find(csv[0].begin(), csv[0].end(), key);
    EXPECT_NE(found, csv[0].end()) << key;
    return static_cast<std::size_t>(found - csv[0].begin());
  };
  const std::size_t error = column("ekf_dqpso_anfis_error_mm");
  const std::size_t x = column("x_mm");
  int compared = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const json& p = points[i];
    if (p["measured_mm"].is_null()) {
      EXPECT_EQ(csv[i + 1][x], "");
      EXPECT_EQ(csv[i + 1][error], "");
      continue;
    }
    EXPECT_EQ(std::stod(csv[i + 1][x]), p["measured_mm"][0].get<double>());
    EXPECT_EQ(
        std::stod(csv[i + 1][error]),
        p["methods"]["ekf_dqpso+anfis"]["error_mm"].get<double>());
    ++compared;
  }
  EXPECT_EQ(compared, 149);
}

TEST(Page, WhatTheFiguresGoBackToIsInTheJsonAsInTheRigFile) {
  ReportData data = sample_session();
  const json nothing = json::parse(json_report(data))["head"]["traceability"];
  EXPECT_TRUE(nothing["operator"].is_null());
  EXPECT_TRUE(nothing["parts"].empty());
  data.head.traced = session::traceability_of(
      "operator = \"A. Person\"\n[robot]\nserial = \"R-7\"\n[cuboid]\nserial = \"Q-12\"\n"
      "certificate = \"K 4711\"\ncertified = 2026-01-15\ndue = 2027-01-15\n[[dial]]\n"
      "id = \"A\"\ncertificate = \"D 1\"\n");
  const json told = json::parse(json_report(data))["head"]["traceability"];
  EXPECT_EQ(told["operator"], "A. Person");
  ASSERT_EQ(told["parts"].size(), 3U);
  EXPECT_EQ(
      told["parts"][0], json::parse(R"({"part": "robot", "serial": "R-7", "certificate": null,
                                        "certified": null, "due": null})"));
  EXPECT_EQ(
      told["parts"][1],
      json::parse(R"({"part": "cuboid", "serial": "Q-12", "certificate": "K 4711",
                      "certified": "2026-01-15", "due": "2027-01-15"})"));
  EXPECT_EQ(told["parts"][2]["part"], "dial A");
  EXPECT_EQ(told["parts"][2]["certificate"], "D 1");
}

TEST(Page, SeriesAreGivenInFullToPrograms) {
  const ReportData data = sample_session();
  const auto files = csv_report(data);
  EXPECT_EQ(read_csv(csv_file(files, "convergence.csv")).size(), 402U);  // header, 0..400
  EXPECT_EQ(read_csv(csv_file(files, "parameters_by_iteration.csv")).size(), 1U + 101U + 401U);
  const json report = json::parse(json_report(data));
  EXPECT_EQ(report["schema"], "sixdial.report");
  EXPECT_EQ(report["schema_version"], kJsonSchemaVersion);
  EXPECT_EQ(report["convergence"][1]["best_rmse_mm"].size(), 401U);
  EXPECT_EQ(report["parameters_by_iteration"].size(), 502U);
  EXPECT_THAT(csv_file(files, "schema.csv"), HasSubstr("sixdial.report.csv,1,"));
}

}  // namespace
}  // namespace sixdial::report
