// The assessment as sections of a report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "report/sections/contour.h"
#include "report/sections/sections_of_studies.h"
#include "report/tables.h"
#include "studies/assessment.h"

namespace sixdial::report {
namespace {

using report::Column;
using report::number;
using report::whole;

constexpr double kDeg = 180.0 / std::numbers::pi;
constexpr int kLevels = 6;
constexpr int kContourStyle = 3;
constexpr int kWorstStyle = 0;
constexpr std::size_t kGridRowsOnPage = 24;

Column column(std::string key, std::string title, std::string unit = "") {
  return {
      .key = std::move(key), .title = std::move(title), .unit = std::move(unit), .group = ""};
}

double number_of(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<double> numbers_of(const Json& json) {
  std::vector<double> values;
  for (const Json& each : json) values.push_back(number_of(each));
  return values;
}

report::Table parameter_table(const Json& assessment) {
  report::Table table{
      .id = "uncertainty",
      .caption = "Parameters of the least-squares fit with their uncertainty"};
  table.columns = {
      column("name", "parameter"),
      column("unit", "unit"),
      column("nominal", "nominal"),
      column("identified", "identified"),
      column("sd", "standard deviation"),
      column("low_95", "95 % from"),
      column("high_95", "to"),
      column("remark", "remark")};
  for (const Json& each : assessment["parameters"]) {
    const bool angle = each["unit"] == "rad";
    const double shown = angle ? kDeg : 1.0;
    const bool fixed = each["fixed"].get<bool>();
    const auto cell = [&](const char* key) {
      return number(shown * number_of(each[key]), angle ? 5 : 4);
    };
    const auto uncertain = [&](const char* key) { return fixed ? report::Cell{} : cell(key); };
    table.rows.push_back(
        {report::symbol(each["name"].get<std::string>()), std::string(angle ? "deg" : "mm"),
         cell("nominal"), cell("identified"), uncertain("sd"), uncertain("low_95"),
         uncertain("high_95"),
         fixed                             ? std::string("fixed at nominal")
         : each["partly_held"].get<bool>() ? std::string("leans on nominal")
                                           : std::string()});
  }
  table.notes.push_back(assessment["noise"]["words"].get<std::string>() + ".");
  return table;
}

report::Figure uncertainty_map(const Json& assessment) {
  const Json& map = assessment["position_uncertainty"];
  const std::vector<double> x = numbers_of(map["x_mm"]);
  const std::vector<double> y = numbers_of(map["y_mm"]);
  const std::vector<double> radius = numbers_of(map["radius_95_mm"]);
  report::Figure figure;
  figure.id = "uncertainty_map";
  figure.title = "Uncertainty of the predicted position over the workspace";
  figure.shows =
      "Lines of equal uncertainty: with 95 % the identified robot stands within this distance "
      "[mm] of where its parameters say. From the parameters' covariance alone; what the model "
      "does not know comes on top.";
  figure.good =
      "A few times smaller than the dials' noise, and even; rising towards an edge means that "
      "points are missing there.";
  figure.here = fmt::format(
      "Root mean square {:.4f} mm; at worst {:.4f} mm (95 %) near ({:.0f}, {:.0f}) mm.",
      number_of(map["mean_sd_mm"]), number_of(map["max_radius_95_mm"]),
      number_of(map["worst_mm"][0]), number_of(map["worst_mm"][1]));

  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (const double value : radius) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  report::Panel panel;
  panel.x = {.label = "x", .unit = "mm", .low = x.front(), .high = x.back()};
  panel.y = {.label = "y", .unit = "mm", .low = y.front(), .high = y.back()};
  panel.equal_scales = true;
  for (const double level : round_levels(low, high, kLevels)) {
    for (const Polyline& line : contour_lines(x, y, radius, level)) {
      report::Series series{.mark = report::Mark::kLine, .style = kContourStyle};
      for (const Eigen::Vector2d& point : line) {
        series.x.push_back(point.x());
        series.y.push_back(point.y());
      }
      series.label = fmt::format("{:.4g}", level);
      panel.series.push_back(std::move(series));
    }
  }
  report::Series worst{
      .name = "least certain place", .mark = report::Mark::kDots, .style = kWorstStyle};
  worst.x = {number_of(map["worst_mm"][0])};
  worst.y = {number_of(map["worst_mm"][1])};
  panel.series.push_back(std::move(worst));
  figure.chart.panels.push_back(std::move(panel));

  figure.table = {.id = "uncertainty_map", .caption = "Predicted position's uncertainty"};
  figure.table.columns = {
      column("x_mm", "x", "mm"), column("y_mm", "y", "mm"), column("sd_x_mm", "sd of x", "mm"),
      column("sd_y_mm", "sd of y", "mm"), column("radius_95_mm", "95 % within", "mm")};
  figure.table.rows_on_page = kGridRowsOnPage;
  for (std::size_t row = 0; row < y.size(); ++row) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::size_t k = row * x.size() + i;
      figure.table.rows.push_back(
          {number(x[i], 2), number(y[row], 2), number(number_of(map["sd_x_mm"][k]), 5),
           number(number_of(map["sd_y_mm"][k]), 5), number(radius[k], 5)});
    }
  }
  return figure;
}

report::Table precision_table(const Json& precision) {
  report::Table table{.id = "precision", .caption = "Standard deviation by what is fitted"};
  table.columns = {
      column("name", "parameter"), column("unit", "unit"),
      column("positions_sd", "positions of the active three"),
      column("dials_sd", "raw readings of all dials"), column("ratio", "ratio")};
  for (const Json& each : precision["parameters"]) {
    const double shown = each["unit"] == "rad" ? kDeg : 1.0;
    table.rows.push_back(
        {report::symbol(each["name"].get<std::string>()),
         std::string(each["unit"] == "rad" ? "deg" : "mm"),
         number(shown * number_of(each["positions_sd"]), 5),
         number(shown * number_of(each["dials_sd"]), 5), number(number_of(each["ratio"]), 2)});
  }
  table.notes.push_back(fmt::format(
      "Raw readings are {:.2f} times as precise in the geometric mean.",
      number_of(precision["geometric_mean_ratio"])));
  return table;
}

report::Section uncertainty(const Json& assessment) {
  report::Section section{.id = "uncertainty", .heading = "What the numbers are worth"};
  section.blocks.emplace_back(fmt::format(
      "Least-squares fit of {} {} from {} samples of G1. Standard deviations: {}.",
      assessment["readings"].get<int>(),
      assessment["space"] == "dials" ? "raw dial readings" : "coordinates of positions",
      assessment["samples"].get<int>(), assessment["noise"]["words"].get<std::string>()));
  section.blocks.emplace_back(parameter_table(assessment));
  if (assessment["position_uncertainty"].is_object()) {
    section.blocks.emplace_back(uncertainty_map(assessment));
  }
  return section;
}

report::Table mode_table(const Json& assessment) {
  report::Table table{
      .id = "working_modes", .caption = "Condition number of each working mode and of all"};
  table.columns = {
      column("mode", "working mode"), column("samples", "samples"),
      column("condition", "condition number")};
  for (const Json& each : assessment["working_modes"]) {
    table.rows.push_back(
        {each["mode"].get<std::string>(), whole(each["samples"].get<int>()),
         number(number_of(each["condition"]), 0)});
  }
  table.rows.push_back(
      {std::string("pooled"), whole(assessment["samples"].get<int>()),
       number(number_of(assessment["identifiability"]["condition"]), 0)});
  table.notes.emplace_back(
      "Each mode by itself, as if the others had not been measured. Smaller is better; none "
      "is given where a mode leaves a direction open.");
  return table;
}

report::Section cannot_tell(const Json& assessment) {
  report::Section section{.id = "cannot_tell", .heading = "What the data cannot tell"};
  const Json& known = assessment["identifiability"];
  section.blocks.emplace_back(fmt::format(
      "{} of {} free parameters (or combinations of them) are determined. Condition number of "
      "the scaled Jacobian {:.4g}; observability index {:.4f} mm per unit and sample "
      "(geometric "
      "mean of the singular values over the root of the number of samples; larger is better).",
      known["determined"].get<int>(), known["free"].get<int>(), number_of(known["condition"]),
      number_of(known["observability"])));
  if (assessment["working_modes"].size() > 1) {
    section.blocks.emplace_back(mode_table(assessment));
  }
  report::Table held{
      .id = "held_directions", .caption = "Directions held at nominal, as no pose shows them"};
  held.columns = {
      column("direction", "what moves together"), column("singular_value", "singular value"),
      column("effect_mm", "moves the tool at most, for 1 mm of it", "mm")};
  for (const Json& each : known["held"]) {
    held.rows.push_back(
        {each["words"].get<std::string>(), number(number_of(each["singular_value"]), 6),
         number(number_of(each["effect_mm"]), 4)});
  }
  if (held.rows.empty()) {
    section.blocks.emplace_back("Nothing had to be held at nominal.");
  } else {
    held.notes.emplace_back(
        "Along these the robot may differ from its drawing unseen. A small effect means that "
        "it does not matter in this workspace; else measure points that separate them.");
    section.blocks.emplace_back(std::move(held));
  }
  return section;
}

report::Section outliers(const Json& gross_errors) {
  report::Section section{.id = "gross_errors", .heading = "Readings that stand out"};
  if (gross_errors["not_possible"].is_string()) {
    section.blocks.emplace_back(
        "Not checked: " + gross_errors["not_possible"].get<std::string>() + ".");
    return section;
  }
  section.blocks.emplace_back(fmt::format(
      "{} readings of G1 were checked against everything else in the session by a robust fit. "
      "A reading counts as a gross error beyond {:.1f} robust standard deviations (of {:.4f} "
      "mm). {} found.",
      gross_errors["readings"].get<int>(), number_of(gross_errors["limit_times_sigma"]),
      number_of(gross_errors["sigma_mm"]),
      gross_errors["found"].empty() ? std::string("None was")
                                    : fmt::format("{} were", gross_errors["found"].size())));
  for (const char* set : {"g1", "g2"}) {
    const int systematic = gross_errors["systematic"][set].get<int>();
    if (systematic == 0) continue;
    section.blocks.emplace_back(fmt::format(
        "{} readings of {} stand out, more than accidents can: a dial, the rig file or the "
        "model is wrong. None was set aside.",
        systematic, set[1] == '1' ? "G1" : "G2"));
  }
  if (!gross_errors["found"].empty()) {
    section.blocks.emplace_back(fmt::format(
        "They are listed under the quality of the measured data. Raw readings stay as they "
        "were "
        "stored; those of G1 were {}; G2 is judged with all of its readings.",
        gross_errors["set_aside"].get<bool>() ? "not fitted" : "fitted all the same"));
  }
  return section;
}

}  // namespace

std::vector<report::Section> assessment_sections(
    const Json& assessment, const Json& precision, const Json& gross_errors) {
  report::Section worth = uncertainty(assessment);
  if (precision.is_object()) worth.blocks.emplace_back(precision_table(precision));
  return {std::move(worth), cannot_tell(assessment), outliers(gross_errors)};
}

}  // namespace sixdial::report
