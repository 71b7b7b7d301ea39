// The assessment as sections of a report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/units.h"
#include "report/expanded.h"
#include "report/sections/contour.h"
#include "report/sections/sections_of_studies.h"
#include "report/tables.h"
#include "report/views.h"
#include "studies/assessment.h"

namespace sixdial::report {
namespace {

using report::number;
using report::whole;

constexpr int kLevels = 6;
constexpr int kContourStyle = 3;
constexpr int kWorstStyle = 0;
constexpr std::size_t kGridRowsOnPage = 24;

/// Root mean square of the values that are known.
double rms_of(const std::vector<double>& values) {
  double squares = 0.0;
  int count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    squares += value * value;
    ++count;
  }
  return count > 0 ? std::sqrt(squares / count) : std::nan("");
}

/// "12, 34" or "12, 34, 56": a place, in whole millimetres.
std::string place_in_words(const geometry::Position& p) {
  std::string words;
  for (const double each : p) {
    words += fmt::format("{}{:.0f}", words.empty() ? "" : ", ", each);
  }
  return words;
}

/// The numbers of the map, node by node. In space all are at one height.
report::Table uncertainty_table(const studies::PositionMap& map) {
  report::Table table{.id = "uncertainty_map", .caption = "Predicted position's uncertainty"};
  for (const std::string_view axis : coordinates(static_cast<int>(map.worst_mm.size()))) {
    table.columns.push_back(column(fmt::format("{}_mm", axis), std::string(axis), "mm"));
  }
  for (Column each :
       {expanded_column("sd_x_mm", "mm", "of x"), expanded_column("sd_y_mm", "mm", "of y"),
        column("radius_95_mm", "95 % within", "mm")}) {
    table.columns.push_back(std::move(each));
  }
  table.rows_on_page = kGridRowsOnPage;
  geometry::Position at = map.worst_mm;
  for (std::size_t row = 0; row < map.y_mm.size(); ++row) {
    for (std::size_t i = 0; i < map.x_mm.size(); ++i) {
      const std::size_t k = row * map.x_mm.size() + i;
      at.head<2>() << map.x_mm[i], map.y_mm[row];
      std::vector<Cell> cells;
      for (const double each : at) cells.push_back(number(each, 2));
      cells.push_back(expanded(map.sd_x_mm[k], 5));
      cells.push_back(expanded(map.sd_y_mm[k], 5));
      cells.push_back(number(map.radius_95_mm[k], 5));
      table.rows.push_back(std::move(cells));
    }
  }
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
      "Lines of equal uncertainty: with 95 % probability the tool of the identified robot "
      "stands "
      "within this distance [mm] of where its parameters say. Only the uncertainty of the "
      "parameters is in it; what the model does not contain comes on top.";
  figure.good = fmt::format(
      "About as small as the noise of the {} or smaller, and even. Where it rises towards an "
      "edge, points are missing there.",
      has_dials ? "dials" : "positions");
  figure.here = fmt::format(
      "With 95 % probability within {:.4f} mm on average (root mean square over the map), "
      "within "
      "{:.4f} mm at the worst place, near ({}) mm.",
      rms_of(radius), map.max_radius_95_mm, place_in_words(map.worst_mm));
  const bool in_space = map.worst_mm.size() > 2;
  if (in_space) {
    figure.shows += fmt::format(
        " The map is a cut through the measured space at half its height, z = {:.0f} mm, seen "
        "from above.",
        map.worst_mm.z());
  }

  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (const double value : radius) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  report::Panel panel;
  if (in_space) panel.title = fmt::format("at z = {:.0f} mm, from above", map.worst_mm.z());
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

  figure.table = uncertainty_table(map);
  return figure;
}

report::Table precision_table(const studies::Precision& precision) {
  report::Table table{
      .id = "precision",
      .caption = "Expanded uncertainty by what is fitted: positions, or all readings"};
  table.columns = {
      column("name", "parameter"), column("unit", "unit"),
      expanded_column("positions_sd", "", "positions, by three dials"),
      expanded_column("dials_sd", "", "raw readings of all dials"), column("ratio", "ratio")};
  for (const studies::Precision::Row& each : precision.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    table.rows.push_back(
        {report::symbol(each.name), std::string(unit.name),
         expanded(unit.per_unit * each.positions_sd, 5),
         expanded(unit.per_unit * each.dials_sd, 5), number(each.ratio, 2)});
  }
  table.notes.push_back(fmt::format(
      "From the noise alone. A fit of raw readings is {:.2f} times as precise (geometric "
      "mean).",
      precision.geometric_mean_ratio));
  return table;
}

report::Section uncertainty(const studies::Assessment& assessment, bool has_dials) {
  report::Section section{
      .id = "uncertainty", .heading = "Uncertainty of the fit", .in_annex = true};
  section.blocks.emplace_back(fmt::format(
      "Least-squares fit of {} {} from {} samples of G1. What its uncertainties rest on: {}.",
      assessment.readings,
      assessment.space == "dials"   ? "raw dial readings"
      : assessment.space == "poses" ? "coordinates and turns of the tool"
                                    : "coordinates of positions",
      assessment.samples, assessment.noise.words));
  const auto& map = assessment.position_uncertainty;
  if (map && map->worst_mm.size() > 0) {  // else the robot reaches no place of it
    section.blocks.emplace_back(uncertainty_map(*map, has_dials));
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
      "Each mode by itself, as if the others had not been measured. Smaller is better; there "
      "is "
      "none where the points of a mode do not determine every parameter.");
  return table;
}

report::Section cannot_tell(const studies::Assessment& assessment) {
  report::Section section{
      .id = "cannot_tell", .heading = "What the data cannot tell", .in_annex = true};
  const studies::IdentifiabilityRow& known = assessment.identifiability;
  section.blocks.emplace_back(fmt::format(
      "{} of {} free parameters (or combinations of them) are determined. Condition number "
      "{:.4g}; "
      "observability index {:.4f} mm for a unit change and one sample (geometric mean of the "
      "singular values over the root of the number of samples; larger is better).",
      known.determined, known.free, known.condition, known.observability));
  if (assessment.working_modes.size() > 1) {
    section.blocks.emplace_back(mode_table(assessment));
  }
  report::Table held{
      .id = "held_directions",
      .caption = "Combinations of parameters that no pose shows, held at nominal"};
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
        "The robot may differ from its drawing in these without anybody seeing it. A small "
        "effect "
        "means that it does not matter in this workspace; else measure points that show it.");
    section.blocks.emplace_back(std::move(held));
  }
  return section;
}

}  // namespace

std::vector<report::Section> assessment_sections(
    const studies::Assessment& assessment, const std::optional<studies::Precision>& precision,
    bool has_dials) {
  report::Section worth = uncertainty(assessment, has_dials);
  if (precision) worth.blocks.emplace_back(precision_table(*precision));
  return {std::move(worth), cannot_tell(assessment)};
}

}  // namespace sixdial::report
