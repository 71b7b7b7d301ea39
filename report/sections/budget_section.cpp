// The uncertainty budget of the tool's position as a section of a report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/units.h"
#include "report/expanded.h"
#include "report/sections/sections_of_studies.h"
#include "report/text.h"
#include "report/words/budget_words.h"

namespace sixdial::report {
namespace {

using studies::BudgetRow;
using studies::BudgetState;
using studies::UncertaintyBudget;

constexpr double kUm_per_mm = 1000.0;
constexpr double kPercent = 100.0;

/// A unit of a source as people read it, and how many of it one stored unit is.
struct SourceUnit {
  std::string name;
  double per_unit = 1.0;
};
SourceUnit unit_of(const BudgetRow& row) {
  if (row.unit == "mm") return {"\u00B5m", kUm_per_mm};
  if (row.unit == "degC") return {"K", 1.0};
  const geometry::ShownUnit unit = geometry::shown_unit(row.unit);
  return {std::string(unit.name), unit.per_unit};
}

std::string share_of(const BudgetRow& row) {
  switch (row.state) {
    case BudgetState::kCounted:
      return fmt::format("{}\u00A0%", fixed(kPercent * row.share, 1));
    case BudgetState::kExact:
      return "stated as exact";
    case BudgetState::kNotStated:
      return "not stated";
    case BudgetState::kContained:
      return "within the fit";
    case BudgetState::kPart:
      return fmt::format("({}\u00A0%)", fixed(kPercent * row.share, 1));
  }
  return "";
}

Table budget_table(const UncertaintyBudget& budget) {
  const std::string name(measurand_name(budget.measurand));
  Table table{
      .id = "budget_" + name,
      .caption = fmt::format("{}", measurand_in_words(budget.measurand))};
  table.columns = {
      column("source", "source"),
      column("type", "type"),
      column("standard", "standard uncertainty, k = 1"),
      column("unit", "unit"),
      column("sensitivity", "sensitivity", "\u00B5m per unit"),
      column("contribution_um", "contribution", "\u00B5m"),
      column("share", "share")};
  std::string missing;
  for (const BudgetRow& row : budget.rows) {
    const SourceUnit unit = unit_of(row);
    const double standard = unit.per_unit * row.standard;
    const double sensitivity = kUm_per_mm * row.sensitivity / unit.per_unit;
    const std::string source = source_in_words(row, budget.measurand);
    table.rows.push_back(
        {source, std::string(row.by_statistics ? "A" : "B"),
         number(standard, decimals_for(standard)), unit.name,
         number(sensitivity, std::abs(sensitivity) < 10.0 ? 2 : 0),
         number(kUm_per_mm * row.contribution_mm, 2), share_of(row)});
    if (row.state == BudgetState::kNotStated) missing += (missing.empty() ? "" : "; ") + source;
  }
  const auto add_sum = [&](std::string words, double mm, std::string share) {
    table.rows.push_back(
        {std::move(words), Cell{}, Cell{}, Cell{}, Cell{}, number(kUm_per_mm * mm, 2),
         std::move(share)});
  };
  add_sum("Combined standard uncertainty, k = 1", budget.combined_mm, "100\u00A0%");
  table.main_row = table.rows.size();
  add_sum("Expanded uncertainty " + expanded_title(), budget.expanded_mm, "");
  const bool has_parts = std::ranges::any_of(
      budget.rows, [](const BudgetRow& row) { return row.state == BudgetState::kPart; });
  if (has_parts) {
    table.notes.push_back(
        "In brackets: by how much of the variance the sum would fall if this alone were known "
        "exactly. These shares do not add up, as what the readings say of one depends on the "
        "others.");
  }
  if (!missing.empty()) {
    table.notes.push_back(
        "Nobody stated these, so they are not in the sum, and it is too small by them: " +
        missing + ".");
  }
  return table;
}

}  // namespace

std::vector<Section> budget_sections(const std::vector<UncertaintyBudget>& budgets) {
  Section section{
      .id = "uncertainty_budget", .heading = "Uncertainty budget of the tool's position"};
  for (const UncertaintyBudget& each : budgets) {
    if (each.places > 0) section.blocks.emplace_back(budget_table(each));
  }
  if (section.blocks.empty()) return {};
  section.blocks.insert(
      section.blocks.begin(),
      std::string(
          "How far the tool may be from where it is said to be, by source (GUM, JCGM "
          "100:2008). Lengths are distances of the tool, all coordinates together, as root "
          "mean square over the poses of G1. Type A: from the scatter of this session; "
          "type B: from what the rig file states."));
  return {std::move(section)};
}

}  // namespace sixdial::report
