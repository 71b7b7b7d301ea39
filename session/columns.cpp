#include "session/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

namespace sixdial::session {
namespace {

constexpr std::array<std::pair<Column, const char*>, 13> kNames{{
    {Column::kSet, "set"},
    {Column::kPoint, "point"},
    {Column::kRepeat, "repeat"},
    {Column::kTime, "time_utc"},
    {Column::kTheta1, "theta1_rad"},
    {Column::kTheta2, "theta2_rad"},
    {Column::kTargetX, "target_x_mm"},
    {Column::kTargetY, "target_y_mm"},
    {Column::kApproach1, "approach1"},
    {Column::kApproach2, "approach2"},
    {Column::kTemperature, "temperature_c"},
    {Column::kX, "x_mm"},
    {Column::kY, "y_mm"},
}};

std::string ids_of(const geometry::Rig& rig) {
  if (rig.dials.empty()) return "none";
  std::string ids;
  for (const geometry::Dial& dial : rig.dials) {
    if (!ids.empty()) ids += ", ";
    ids += dial.id;
  }
  return ids;
}

/// The id in "dial_<id>_mm".
std::optional<std::string> dial_id_in(const std::string& name) {
  constexpr std::string_view kFront = "dial_";
  constexpr std::string_view kBack = "_mm";
  if (!name.starts_with(kFront) || !name.ends_with(kBack) ||
      name.size() <= kFront.size() + kBack.size()) {
    return std::nullopt;
  }
  return name.substr(kFront.size(), name.size() - kFront.size() - kBack.size());
}

/// The unknown column that was most likely meant to be `wanted`.
std::string likely_meant(const std::vector<HeaderColumn>& columns, const std::string& wanted) {
  std::vector<std::string> unknown;
  for (const HeaderColumn& column : columns) {
    if (column.column == Column::kUnknown) unknown.push_back(column.name);
  }
  const std::string nearest = nearest_word(wanted, unknown);
  if (nearest.empty()) return "";
  return fmt::format("; was {} meant?", shown(nearest));
}

}  // namespace

std::string column_name(Column column) {
  for (const auto& [each, name] : kNames) {
    if (each == column) return name;
  }
  return "";
}

std::string dial_column_name(const std::string& dial_id) {
  return fmt::format("dial_{}_mm", dial_id);
}

std::vector<HeaderColumn> read_header(
    const CsvRow& header, const geometry::Rig& rig, std::vector<Finding>& findings) {
  std::vector<HeaderColumn> columns;
  std::map<std::string, int> seen;
  if (header.fault) findings.push_back(*header.fault);
  for (const CsvField& field : header.fields) {
    HeaderColumn column{Column::kUnknown, 0, field.value};
    for (const auto& [each, name] : kNames) {
      if (field.value == name) column.column = each;
    }
    if (const auto id = dial_id_in(field.value)) {
      if (const auto dial = rig.find_dial(*id)) {
        column.column = Column::kDial;
        column.dial = *dial;
      } else {
        findings.push_back(
            {header.line, field.column, field.value,
             fmt::format("dial {} is not in the rig file", shown(*id)),
             fmt::format("the rig file's dials: {}", ids_of(rig))});
      }
    }
    if (++seen[field.value] == 2) {
      findings.push_back(
          {header.line, field.column, field.value, "the column appears twice",
           "give each column a name of its own"});
    }
    columns.push_back(std::move(column));
  }
  const auto has = [&](Column wanted) {
    return std::any_of(columns.begin(), columns.end(), [&](const HeaderColumn& c) {
      return c.column == wanted;
    });
  };
  // A header in one piece is a table with another separator.
  const bool other_separator =
      columns.size() == 1 && columns[0].name.find_first_of(";\t|") != std::string::npos;
  const int after_last =
      header.fields.back().column + static_cast<int>(header.fields.back().value.size());
  const auto need = [&](Column column, const char* why) {
    if (has(column)) return;
    const std::string name = column_name(column);
    findings.push_back(
        {header.line, after_last, name, "the column is missing",
         other_separator ? std::string("separate columns by commas")
                         : why + likely_meant(columns, name)});
  };
  need(Column::kSet, "add it: G1 calibrates, G2 validates");
  need(Column::kTheta1, "add the first encoder angle in radians");
  need(Column::kTheta2, "add the second encoder angle in radians");
  if (has(Column::kX) != has(Column::kY)) {
    need(Column::kX, "a position needs x_mm and y_mm");
    need(Column::kY, "a position needs x_mm and y_mm");
  } else if (!has(Column::kX) && !has(Column::kDial)) {
    findings.push_back(
        {header.line, after_last, "", "there are no dial columns and no x_mm, y_mm",
         fmt::format(
             "add dial_<id>_mm for the rig file's dials ({}) or x_mm and y_mm", ids_of(rig))});
  }
  if (has(Column::kTargetX) != has(Column::kTargetY)) {
    need(Column::kTargetX, "a target needs target_x_mm and target_y_mm");
    need(Column::kTargetY, "a target needs target_x_mm and target_y_mm");
  }
  return columns;
}

std::vector<HeaderColumn> spec_columns(
    const geometry::Rig& rig, bool with_dials, bool with_position) {
  std::vector<HeaderColumn> columns;
  for (const auto& [column, name] : kNames) {
    if (column == Column::kX || column == Column::kY) continue;
    columns.push_back({column, 0, name});
  }
  for (std::size_t i = 0; with_dials && i < rig.dials.size(); ++i) {
    columns.push_back({Column::kDial, i, dial_column_name(rig.dials[i].id)});
  }
  if (with_position) {
    columns.push_back({Column::kX, 0, column_name(Column::kX)});
    columns.push_back({Column::kY, 0, column_name(Column::kY)});
  }
  return columns;
}

}  // namespace sixdial::session
