// One number, one place, one name: every figure that a finished report shows twice is the same
// figure. Drawn sessions are calibrated and diagnosed, and the page is read as a person reads
// it: tables by their captions and heads, sentences by their words.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "mock_devices/session_generator.h"
#include "report/html_report.h"
#include "report/report_run.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "studies/diagnose.h"
#include "tests/report/page_parts.h"

namespace sixdial::studies {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

struct Drawn {
  const char* name;
  const char* effect;  // as sixdial-mock-rig --hide takes it; empty: none
  double gross_share;  // of the readings
  double warp_mm;
  std::uint64_t seed;
};

session::Session session_of(const Drawn& drawn) {
  mock_devices::World world;
  world.robot = mock_devices::drawn_robot(world.rig, drawn.seed);
  world.dials = {0.002, 0.001, 0.0, 0.0};
  world.seed = drawn.seed;
  world.warp.amplitude_mm = drawn.warp_mm;
  if (*drawn.effect != '\0') {
    world.effects.push_back(mock_devices::parse_effect(world.rig, drawn.effect, drawn.seed));
  }
  if (drawn.gross_share > 0.0) {
    world.effects.push_back(
        {"outliers", "samples", {{"share", drawn.gross_share}, {"size_mm", 0.3}, {"seed", 8}}});
  }
  return session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(
              world, mock_devices::random_plan(world.rig, drawn.seed, 80, 40)),
          world.rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(world.rig), "rig.toml");
}

/// What a reader sees of a page: no scripts, no tags, characters instead of entities.
std::string text_of(const std::string& page) {
  const std::string markup = report::without_scripts(page);
  std::string text;
  for (std::size_t at = markup.find("<body>"); at < markup.size();) {
    const std::size_t open = std::min(markup.find('<', at), markup.size());
    text += markup.substr(at, open - at) + ' ';
    at = open < markup.size() ? std::min(markup.find('>', open), markup.size() - 1) + 1 : open;
  }
  for (const auto& [entity, character] :
       {std::pair{"&amp;", "&"},
        {"&lt;", "<"},
        {"&gt;", ">"},
        {"&#39;", "'"},
        {"&quot;", "\""},
        {"\u00A0", " "}}) {
    for (std::size_t at; (at = text.find(entity)) != std::string::npos;) {
      text.replace(at, std::string(entity).size(), character);
    }
  }
  return std::regex_replace(text, std::regex("\\s+"), " ");
}

/// A finished page with both studies, taken apart.
class Page {
 public:
  explicit Page(const Drawn& drawn) {
    const session::Session session = session_of(drawn);
    CalibrationRequest request;
    request.seed = drawn.seed;
    request.particles = 12;
    request.qpso1_iterations = 12;
    request.qpso2_iterations = 40;
    request.anfis_epochs = 20;
    request.tolerance_mm = 0.05;
    const CalibrationResult result = calibrate(session, request);
    const DiagnosisResult diagnosis = diagnose(session, {.bootstrap = 0});
    const std::string page = report::html_report(
        report::report_data(result, session, "tester", {.diagnosis = &diagnosis}),
        {.charts = false});
    tables_ = report::tables_of(page)["tables"];
    text_ = text_of(page);
  }

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool has(const std::string& table) const { return tables_.contains(table); }
  [[nodiscard]] const json& rows(const std::string& table) const {
    return tables_.at(table)["rows"];
  }
  /// The heads of a table's columns, group and title, without units.
  [[nodiscard]] const json& head(const std::string& table) const {
    return tables_.at(table)["head"];
  }
  /// Row whose first cell is `name`.
  [[nodiscard]] json row(const std::string& table, const std::string& name) const {
    for (const json& each : rows(table)) {
      if (each[0] == name) return each;
    }
    ADD_FAILURE() << "no row " << name << " in " << table;
    return {};
  }
  /// Row of Table 6 of the model that is recommended.
  [[nodiscard]] json recommended_method() const {
    for (const json& each : rows("recommendation_2")) {
      if (each.back() != "recommended") continue;
      const bool alone = each[0] == "identified parameters";
      return alone ? row("table6", "EKF-DQPSO") : rows("table6").back();
    }
    ADD_FAILURE() << "nothing is recommended";
    return {};
  }
  /// Groups of the first match in the text; empty: there is none.
  [[nodiscard]] std::vector<std::string> said(const std::string& pattern) const {
    std::smatch match;
    if (!std::regex_search(text_, match, std::regex(pattern))) return {};
    return {match.begin() + 1, match.end()};
  }
  /// Every match's first group.
  [[nodiscard]] std::vector<std::string> all_said(const std::string& pattern) const {
    const std::regex wanted(pattern);
    std::vector<std::string> out;
    for (std::sregex_iterator each(text_.begin(), text_.end(), wanted), end; each != end;
         ++each) {
      out.push_back((*each)[1]);
    }
    return out;
  }

 private:
  json tables_;
  std::string text_;
};

/// "17.1 µm" or "2.85 mm" in mm, with half a unit of its last digit.
struct Length {
  double mm = 0.0, rounded_mm = 0.0;
};
Length length_in(const std::string& text) {
  const double to_mm = text.find("\u00B5m") != std::string::npos ? 1e-3 : 1.0;
  const std::string digits = text.substr(0, text.find(' '));
  const std::size_t point = digits.find('.');
  const double decimals =
      point == std::string::npos ? 0.0 : static_cast<double>(digits.size() - point - 1);
  return {std::stod(digits) * to_mm, 0.5 * std::pow(10.0, -decimals) * to_mm};
}

/// Two texts of one figure: they differ by no more than both were rounded.
void expect_same(const std::string& a, const std::string& b, const std::string& what) {
  const Length first = length_in(a);
  const Length second = length_in(b);
  constexpr double kOfDoubles = 1e-9;
  EXPECT_LE(std::abs(first.mm - second.mm), first.rounded_mm + second.rounded_mm + kOfDoubles)
      << what << ": " << a << " and " << b;
}

class EveryDrawnReport : public ::testing::TestWithParam<Drawn> {};

constexpr const char* kLength = "(\\d+(?:\\.\\d+)? (?:mm|\u00B5m))";

void expect_position_errors(const Page& page) {
  // The figures that are read first are those of the recommended model: on G2 by position
  // errors (Table 6: method, then mean, std and max of G1, then of G2), or, with causes, by
  // tool shifts.
  const bool by_shift =
      page.text().find("mean tool shift before and after") != std::string::npos;
  const json best =
      by_shift ? page.row("gain_2", "with the causes") : page.recommended_method();
  const json drawn =
      by_shift ? page.row("gain_2", "nominal parameters") : page.rows("table6").front();
  const std::size_t mean = by_shift ? 1 : 4;
  const std::size_t max = by_shift ? 3 : 6;
  const std::string before_mean = drawn[mean].get<std::string>() + " mm";
  const std::string after_mean = best[mean].get<std::string>() + " mm";
  const std::string after_max = best[max].get<std::string>() + " mm";
  const auto big = page.said("(\\d+\\.\\d+) \u2192 (\\d+\\.\\d+) mm");
  ASSERT_EQ(big.size(), 2U);
  expect_same(big[0] + " mm", before_mean, "before, in large digits");
  expect_same(big[1] + " mm", after_mean, "after, in large digits");
  const auto missed = page.said(
      fmt::format("missed its positions by {0} on average and {0} at worst", kLength));
  ASSERT_EQ(missed.size(), 2U);
  expect_same(missed[0], before_mean, "before");
  expect_same(missed[1], drawn[max].get<std::string>() + " mm", "worst before");
  const auto remains =
      page.said(fmt::format("error is (?:still )?{0} on average and {0} at worst", kLength));
  ASSERT_EQ(remains.size(), 2U);
  expect_same(remains[0], after_mean, "after");
  expect_same(remains[1], after_max, "worst after");
  const auto by_point = page.said(fmt::format("G2 mean {0}, worst {0}", kLength));
  ASSERT_EQ(by_point.size(), 2U);
  const json& delivered = page.rows("table6").back();
  expect_same(by_point[0], delivered[4].get<std::string>() + " mm", "mean, by point");
  expect_same(by_point[1], delivered[6].get<std::string>() + " mm", "worst, by point");
  // The largest remaining error heads its own list.
  const double largest = std::max(
      std::stod(delivered[3].get<std::string>()), std::stod(delivered[6].get<std::string>()));
  expect_same(
      page.rows("worst_points")[0].back().get<std::string>() + " mm",
      fmt::format("{:.4f} mm", largest), "largest remaining error");
  const auto judged = page.said("worst: (\\d\\.\\d{4} mm) with U = (\\d\\.\\d{4} mm)");
  if (!judged.empty()) {
    EXPECT_LE(length_in(judged[0]).mm, length_in(after_max).mm + 1e-4);
  }
}

void expect_readings_that_stand_out(const Page& page) {
  const std::size_t listed = page.has("outliers") ? page.rows("outliers").size() : 0;
  EXPECT_EQ(page.rows("counts").back()[1].get<std::string>(), std::to_string(listed));
  long not_fitted = 0;
  long not_diagnosed = 0;
  for (std::size_t i = 0; i < listed; ++i) {
    const auto done = page.rows("outliers")[i].back().get<std::string>();
    not_fitted += done.find("not fitted") != std::string::npos ? 1 : 0;
    not_diagnosed += done.find("not diagnosed") != std::string::npos ? 1 : 0;
  }
  const auto numbers_equal = [&](const std::string& pattern, long wanted) {
    for (const std::string& each : page.all_said(pattern)) {
      EXPECT_EQ(std::stol(each), wanted) << pattern;
    }
  };
  numbers_equal("(\\d+) measured values? do(?:es)? not agree", static_cast<long>(listed));
  numbers_equal("the calibration left out (\\d+)", not_fitted);
  numbers_equal("the diagnosis left out (\\d+)", not_diagnosed);
  numbers_equal("Gross reading errors: (\\d+) reading", not_diagnosed);
  EXPECT_FALSE(page.has("gross_readings"));  // no second list with sizes of its own
}

void expect_parameters(const Page& page) {
  std::map<std::string, std::string> identified;
  for (const json& row : page.rows("table2")) identified[row[0]] = row[4];
  ASSERT_EQ(identified.size(), 10U);
  ASSERT_TRUE(page.has("fits"));
  EXPECT_EQ(page.head("fits")[0][2], "identified");
  for (const json& row : page.rows("fits")) {
    expect_same(identified.at(row[0]), row[2], "identified " + row[0].get<std::string>());
  }
  if (page.has("recommended_parameters")) {
    for (const json& row : page.rows("recommended_parameters")) {
      const json by_fit = page.row("fits", row[0]);
      expect_same(
          row[4], by_fit[by_fit.size() - 2], "recommended " + row[0].get<std::string>());
    }
  }
  for (const char* other : {"moved_parameters", "uncertainty"}) {
    EXPECT_FALSE(page.has(other)) << "a second place for parameters";
  }
}

void expect_tool_shifts(const Page& page) {
  if (!page.has("gain_2")) return;  // too few points to judge
  const std::string alone = page.row("gain_2", "robot alone")[1];
  const auto falls = page.said(
      "mean tool shift [^.]*falls from (\\d\\.\\d{4} mm) with the robot's parameters alone to "
      "(\\d\\.\\d{4} mm)");
  if (!falls.empty()) {
    expect_same(falls[0], alone + " mm", "tool shift, robot alone");
    const json with = page.row("gain_2", "with the causes");
    expect_same(falls[1], with[1].get<std::string>() + " mm", "tool shift with the causes");
    // All that two figures of four decimals can stand for, and a whole percent.
    const Length before = length_in(alone);
    const Length after = length_in(with[1]);
    const auto share = [&](double half_steps) {
      return 100.0 * (1.0 - (after.mm - half_steps * after.rounded_mm) /
                                (before.mm + half_steps * before.rounded_mm));
    };
    constexpr double kRounded = 0.5;
    const double said = std::stod(with.back().get<std::string>());
    EXPECT_GE(said, share(-1.0) - kRounded) << alone << " and " << with;
    EXPECT_LE(said, share(1.0) + kRounded) << alone << " and " << with;
  }
  // The other error of the page has another name.
  EXPECT_THAT(page.text(), ::testing::Not(HasSubstr("Held-out position error")));
}

void expect_causes(const Page& page) {
  if (!page.has("causes")) return;
  for (const json& row : page.rows("causes")) {
    const auto size = row[1].get<std::string>();
    if (size.find("\u00B1") == std::string::npos) continue;
    EXPECT_THAT(size, HasSubstr("(k = 2)"));
    const auto name = row[0].get<std::string>();
    EXPECT_THAT(page.text(), HasSubstr(name + ": " + size)) << "in the first box";
    std::size_t places = 0;
    for (std::size_t at = 0; (at = page.text().find(size, at)) != std::string::npos; ++at) {
      ++places;
    }
    EXPECT_GE(places, 3U) << name << ": box, table, section";
  }
}

void expect_noise_and_fit(const Page& page) {
  const auto noise =
      page.said(fmt::format("noise of the measured positions \\({}, k = 1\\)", kLength));
  if (!noise.empty()) {
    expect_same(
        noise[0],
        page.row(
            "provenance", "standard deviation of a measured position, from the dials alone")[1],
        "noise of a position");
  }
  const auto rmse = page.said("The parameters' RMSE is (\\d\\.\\d+ mm)");
  if (!rmse.empty()) {
    expect_same(
        rmse[0],
        page.row("objective", "root mean square error of the identified parameters")[1]
                .get<std::string>() +
            " mm",
        "root mean square error");
  }
  const auto conditions =
      page.all_said("[Cc]ondition number (?:of the fit: )?(\\d+(?:\\.\\d+)?)");
  for (const std::string& each : conditions) {
    expect_same(conditions.front(), each, "condition number");
  }
}

TEST_P(EveryDrawnReport, ShowsEveryFigureThatStandsTwiceTheSame) {
  const Page page(GetParam());
  expect_position_errors(page);
  expect_readings_that_stand_out(page);
  expect_parameters(page);
  expect_tool_shifts(page);
  expect_causes(page);
  expect_noise_and_fit(page);
  // Where "±" stands, k is said.
  const auto plus_minus = page.all_said("(\u00B1 .{0,60})");
  for (const std::string& each : plus_minus) EXPECT_THAT(each, HasSubstr("k = ")) << each;
}

INSTANTIATE_TEST_SUITE_P(
    , EveryDrawnReport,
    ::testing::Values(
        Drawn{"Clean", "", 0.0, 0.0, 31}, Drawn{"Gross", "", 0.01, 0.0, 32},
        Drawn{"Backlash", "joint_backlash:joint2:0.0006", 0.01, 0.0, 33},
        Drawn{"Thermal", "link_thermal_growth:links:6e-05", 0.0, 0.0, 34}),
    [](const auto& each) { return std::string{each.param.name}; });

TEST(ReportTime, IsNeverBeforeTheMeasuringWithoutASign) {
  const session::Session session = session_of({"", "", 0.0, 0.0, 35});
  CalibrationRequest request;
  request.method = "lm";
  const CalibrationResult result = calibrate(session, request);
  const auto last = session.samples.back().time_utc.value();
  const auto page_made = [&](session::TimePoint made) {
    return text_of(report::html_report(
        report::report_data(result, session, "tester", {.made = made}), {.charts = false}));
  };
  EXPECT_THAT(
      page_made(last - std::chrono::minutes(5)),
      HasSubstr("by a clock that is behind that of the samples"));
  EXPECT_THAT(
      page_made(last + std::chrono::minutes(5)),
      ::testing::Not(HasSubstr("by a clock that is behind")));
}

}  // namespace
}  // namespace sixdial::studies
