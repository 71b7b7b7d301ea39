// The assessment as sections of a report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/units.h"
#include "report/sections/contour.h"
#include "report/sections/sections_of_studies.h"
#include "report/tables.h"
#include "studies/assessment.h"

namespace sixdial::report {
namespace {

using report::Column;
using report::number;
using report::whole;

constexpr int kLevels = 6;
constexpr int kContourStyle = 3;
constexpr int kWorstStyle = 0;
constexpr std::size_t kGridRowsOnPage = 24;

Column column(std::string key, std::string title, std::string unit = "") {
  return {
      .key = std::move(key), .title = std::move(title), .unit = std::move(unit), .group = ""};
}

report::Table parameter_table(const studies::Assessment& assessment) {
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
  for (const studies::ParameterRow& each : assessment.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    const auto cell = [&](double value) {
      return number(unit.per_unit * value, each.unit == "rad" ? 5 : 4);
    };
    const auto uncertain = [&](double value) {
      return each.fixed ? report::Cell{} : cell(value);
    };
    table.rows.push_back(
        {report::symbol(each.name), std::string(unit.name), cell(each.nominal),
         cell(each.identified), uncertain(each.sd), uncertain(each.low_95),
         uncertain(each.high_95),
         each.fixed         ? std::string("fixed at nominal")
         : each.partly_held ? std::string("leans on nominal")
                            : std::string()});
  }
  table.notes.push_back(assessment.noise.words + ".");
  return table;
}

report::Figure uncertainty_map(const studies::PositionMap& map, bool has_dials) {
  const std::vector<double>& x = map.x_mm;
  const std::vector<double>& y = map.y_mm;
  const std::vector<double>& radius = map.radius_95_mm;
  report::Figure figure;
  figure.id = "uncertainty_map";
  figure.title = "Uncertainty of the predicted position over the workspace";
  figure.shows =
      "Lines of equal uncertainty: with 95 % the identified robot stands within this distance "
      "[mm] of where its parameters say. From the parameters' covariance alone; what the model "
      "does not know comes on top.";
  figure.good = fmt::format(
      "A few times smaller than the {} noise, and even; rising towards an edge means that "
      "points are missing there.",
      has_dials ? "dials'" : "positions'");
  figure.here = fmt::format(
      "Root mean square {:.4f} mm; at worst {:.4f} mm (95 %) near ({:.0f}, {:.0f}) mm.",
      map.mean_sd_mm, map.max_radius_95_mm, map.worst_mm.x(), map.worst_mm.y());

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
  worst.x = {map.worst_mm.x()};
  worst.y = {map.worst_mm.y()};
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
          {number(x[i], 2), number(y[row], 2), number(map.sd_x_mm[k], 5),
           number(map.sd_y_mm[k], 5), number(radius[k], 5)});
    }
  }
  return figure;
}

report::Table precision_table(const studies::Precision& precision) {
  report::Table table{.id = "precision", .caption = "Standard deviation by what is fitted"};
  table.columns = {
      column("name", "parameter"), column("unit", "unit"),
      column("positions_sd", "positions of the active three"),
      column("dials_sd", "raw readings of all dials"), column("ratio", "ratio")};
  for (const studies::Precision::Row& each : precision.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    table.rows.push_back(
        {report::symbol(each.name), std::string(unit.name),
         number(unit.per_unit * each.positions_sd, 5), number(unit.per_unit * each.dials_sd, 5),
         number(each.ratio, 2)});
  }
  table.notes.push_back(fmt::format(
      "Raw readings are {:.2f} times as precise in the geometric mean.",
      precision.geometric_mean_ratio));
  return table;
}

report::Section uncertainty(const studies::Assessment& assessment, bool has_dials) {
  report::Section section{.id = "uncertainty", .heading = "What the numbers are worth"};
  section.blocks.emplace_back(fmt::format(
      "Least-squares fit of {} {} from {} samples of G1. Standard deviations: {}.",
      assessment.readings,
      assessment.space == "dials" ? "raw dial readings" : "coordinates of positions",
      assessment.samples, assessment.noise.words));
  section.blocks.emplace_back(parameter_table(assessment));
  if (assessment.position_uncertainty) {
    section.blocks.emplace_back(uncertainty_map(*assessment.position_uncertainty, has_dials));
  }
  return section;
}

report::Table mode_table(const studies::Assessment& assessment) {
  report::Table table{
      .id = "working_modes", .caption = "Condition number of each working mode and of all"};
  table.columns = {
      column("mode", "working mode"), column("samples", "samples"),
      column("condition", "condition number")};
  for (const studies::WorkingModeRow& each : assessment.working_modes) {
    table.rows.push_back(
        {geometry::to_string(each.mode), whole(each.samples), number(each.condition, 0)});
  }
  table.rows.push_back(
      {std::string("pooled"), whole(assessment.samples),
       number(assessment.identifiability.condition, 0)});
  table.notes.emplace_back(
      "Each mode by itself, as if the others had not been measured. Smaller is better; none "
      "is given where a mode leaves a direction open.");
  return table;
}

report::Section cannot_tell(const studies::Assessment& assessment) {
  report::Section section{.id = "cannot_tell", .heading = "What the data cannot tell"};
  const studies::IdentifiabilityRow& known = assessment.identifiability;
  section.blocks.emplace_back(fmt::format(
      "{} of {} free parameters (or combinations of them) are determined. Condition number of "
      "the scaled Jacobian {:.4g}; observability index {:.4f} mm per unit and sample "
      "(geometric "
      "mean of the singular values over the root of the number of samples; larger is better).",
      known.determined, known.free, known.condition, known.observability));
  if (assessment.working_modes.size() > 1) {
    section.blocks.emplace_back(mode_table(assessment));
  }
  report::Table held{
      .id = "held_directions", .caption = "Directions held at nominal, as no pose shows them"};
  held.columns = {
      column("direction", "what moves together"), column("singular_value", "singular value"),
      column("effect_mm", "moves the tool at most, for 1 mm of it", "mm")};
  for (const studies::HeldRow& each : known.held) {
    held.rows.push_back(
        {each.words, number(each.singular_value, 6), number(each.effect_mm, 4)});
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

report::Section outliers(const studies::GrossErrors& errors) {
  report::Section section{.id = "gross_errors", .heading = "Readings that stand out"};
  if (errors.not_possible) {
    section.blocks.emplace_back("Not checked: " + *errors.not_possible + ".");
    return section;
  }
  section.blocks.emplace_back(fmt::format(
      "{} readings of G1 were checked against everything else in the session by a robust fit. "
      "A reading counts as a gross error beyond {:.1f} robust standard deviations (of {:.4f} "
      "mm). {} found.",
      errors.readings, errors.limit_times_sigma, errors.sigma_mm,
      errors.found.empty() ? std::string("None was")
                           : fmt::format("{} were", errors.found.size())));
  for (const auto& [set, systematic] :
       {std::pair{"G1", errors.systematic_g1}, std::pair{"G2", errors.systematic_g2}}) {
    if (systematic == 0) continue;
    section.blocks.emplace_back(fmt::format(
        "{} readings of {} stand out, more than accidents can: a dial, the rig file or the "
        "model is wrong. None was set aside.",
        systematic, set));
  }
  if (!errors.found.empty()) {
    section.blocks.emplace_back(fmt::format(
        "They are listed under the quality of the measured data. Raw readings stay as they "
        "were stored; those of G1 were {}; G2 is judged with all of its readings.",
        errors.set_aside ? "not fitted" : "fitted all the same"));
  }
  return section;
}

}  // namespace

std::vector<report::Section> assessment_sections(
    const studies::Assessment& assessment, const std::optional<studies::Precision>& precision,
    const studies::GrossErrors& gross_errors, bool has_dials) {
  report::Section worth = uncertainty(assessment, has_dials);
  if (precision) worth.blocks.emplace_back(precision_table(*precision));
  return {std::move(worth), cannot_tell(assessment), outliers(gross_errors)};
}

}  // namespace sixdial::report
