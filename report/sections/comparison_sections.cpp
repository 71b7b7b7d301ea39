#include <fmt/format.h>

#include "report/sections/sections_of_studies.h"
#include "report/words/comparison_words.h"
#include "report/words/rig_words.h"

namespace sixdial::report {
namespace {

void add_figures(std::vector<Cell>& row, const std::optional<calibration::ErrorStats>& set) {
  if (!set) {
    row.insert(row.end(), 3, Cell{});
    return;
  }
  for (const double each : {set->mean_mm, set->std_mm, set->max_mm}) {
    row.push_back(number(each));
  }
}

Table table_6(const studies::ComparisonResult& result) {
  Table table{.id = "comparison", .caption = "Absolute position error by method, as Table 6"};
  table.columns = {column("method", "method")};
  for (const auto& [set, group] :
       {std::pair{"g1", "G1 calibration"}, std::pair{"g2", "G2 validation"}}) {
    for (const char* what : {"mean", "std", "max"}) {
      table.columns.push_back(column(fmt::format("{}_{}_mm", set, what), what, "mm", group));
    }
  }
  table.columns.push_back(column("seconds", "time", "s"));
  for (const studies::ComparedRow& method : result.methods) {
    if (method.id == result.best) table.main_row = table.rows.size();
    std::vector<Cell> row{method.name};
    add_figures(row, method.g1);
    add_figures(row, method.g2);
    row.push_back(number(method.seconds(), 4));
    table.rows.push_back(std::move(row));
  }
  table.notes.push_back(fmt::format(
      "Before: {}. Lowest mean on G2 in bold. Figures are differences between measured and "
      "modelled positions.",
      before_in_words(result.before_uses_targets)));
  return table;
}

}  // namespace

std::vector<Section> comparison_sections(const studies::ComparisonResult& result) {
  Section section{
      .id = "comparison", .heading = "All methods on this session", .in_annex = true};
  section.blocks.emplace_back(fmt::format(
      "Each method identified the robot from G1 ({}) and was judged by G2, which none of them "
      "used. "
      "Times are those of this machine, identification and residual model together.",
      result.choices.space == "dials" ? "raw readings of all dials in contact"
                                      : "measured positions"));
  section.blocks.emplace_back(table_6(result));
  if (const std::string rig = result.rig ? rig_in_words(*result.rig) : ""; !rig.empty()) {
    section.blocks.emplace_back(
        "Every method was given the rig as the readings see it, fitted before any of them. " +
        rig);
  }

  Table learned{.id = "residual_models", .caption = "What the residual models used"};
  learned.columns = {
      column("method", "method"), column("effective_x", "effective parameters, x"),
      column("effective_y", "effective parameters, y"), column("note", "chosen")};
  for (const studies::ComparedRow& method : result.methods) {
    if (!method.residual) continue;
    const Eigen::Vector2d& effective = method.residual->effective_parameters;
    learned.rows.push_back(
        {method.name, number(effective.x(), 1), number(effective.y(), 1),
         method.residual->note});
  }
  if (!learned.rows.empty()) section.blocks.emplace_back(std::move(learned));
  return {std::move(section)};
}

}  // namespace sixdial::report
