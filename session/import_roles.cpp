#include "session/import_roles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "session/csv.h"
#include "session/import_guess.h"
#include "session/import_seen.h"
#include "session/import_units.h"

namespace sixdial::session {
namespace {

std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// "q1_rad" and "q1_deg" are the same.
std::string without_unit(const std::string& to) { return to.substr(0, to.rfind('_')); }

/// The lines that would give one of `missing`: of a column that looks like it, else of any that
/// the map does not use.
std::string example(
    const std::vector<std::string>& missing, const ImportMap& map, const SampleLayout& layout,
    const ImportTable& table) {
  const Guess guess = guess_columns(table, &layout);
  for (const std::string& to : missing) {
    const auto found = std::ranges::find_if(guess.columns, [&](const GuessedColumn& each) {
      return without_unit(each.to) == without_unit(to);
    });
    if (found != guess.columns.end()) return map_lines(table, *found);
  }
  const auto quaternion = std::ranges::find(guess.columns, "qw", &GuessedColumn::to);
  if (quaternion != guess.columns.end() && missing.front().starts_with("r")) {
    return map_lines(table, *quaternion);
  }
  GuessedColumn any{.column = table.names.size(), .to = missing.front()};
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    const bool used =
        std::ranges::find(map.columns, table.names[k], &MapColumn::from) != map.columns.end() ||
        std::ranges::find(guess.columns, k, &GuessedColumn::column) != guess.columns.end() ||
        guess.left_out.contains(k);
    if (!used && values_of(table, k).numbers > 0) any.column = k;
  }
  if (any.column == table.names.size()) any.column = table.names.size() - 1;
  any.unit = any.to.ends_with("_rad") ? "deg" : any.to.ends_with("_mm") ? "mm" : "";
  return map_lines(table, any);
}

std::string hint_for(
    const std::vector<std::string>& missing, const ImportMap& map, const SampleLayout& layout,
    const ImportTable& table) {
  return fmt::format(
      "{} has {} columns: {}. Add to the map what they are, such as:\n{}"
      "(sixdial import FILE --guess --rig RIG.toml writes a first map)",
      table.file, table.names.size(), names_in_words(table),
      example(missing, map, layout, table));
}

}  // namespace

bool is_measured(const std::string& to) {
  return to != "set" && to != "time_utc" && to != "temperature_c" &&
         !to.starts_with("target_") && !to.starts_with("approach") && !to.starts_with("sd_") &&
         to.find("_command_") == std::string::npos;
}

Mistake joints_missing(
    const std::vector<std::string>& missing, const ImportMap& map, const SampleLayout& layout,
    const ImportTable& table) {
  return {
      0, 0, missing.front(),
      missing.size() == 1 ? std::string("no [[column]] gives this joint")
                          : fmt::format(
                                "no [[column]] gives {} of the {} joints: {}", missing.size(),
                                layout.joints.size(), list_of(missing)),
      hint_for(missing, map, layout, table)};
}

std::optional<Mistake> nothing_measured(
    const ImportMap& map, const SampleLayout& layout, const ImportTable& table) {
  for (const MapColumn& column : map.columns) {
    const bool joint = std::ranges::any_of(layout.joints, [&](const Joint& each) {
      const auto number = fmt::format("q{}", &each - layout.joints.data() + 1);
      return without_unit(column.to) == each.name || without_unit(column.to) == number;
    });
    if (!joint && is_measured(column.to)) return std::nullopt;
  }
  const std::vector<std::string> needed = needed_measured(layout);
  return Mistake{
      0, 0, needed.front(),
      fmt::format(
          "the map gives nothing that was measured; this rig's instrument measures {}",
          list_of(needed)),
      hint_for(needed, map, layout, table)};
}

Mistake no_row_left(const ImportMap& map, const RowsLeftOut& left_out) {
  if (left_out.rows == 0) {
    return {
        0, 0, "", "the file has no row with as many cells as it has columns",
        "look at separator, skip_lines and header of [file]"};
  }
  std::string empty;
  for (std::size_t k = 0; k < left_out.no_value.size(); ++k) {
    if (left_out.no_value[k] < left_out.rows) continue;
    empty += fmt::format(
        "{}{} ({})", empty.empty() ? "" : ", ", map.columns[k].to, map.columns[k].from);
  }
  std::string hint;
  if (!empty.empty()) hint = fmt::format("no row has a value of {}", empty);
  for (const std::string& odd : left_out.odd) hint += (hint.empty() ? "" : "; ") + odd;
  return {
      0, 0, "",
      fmt::format(
          "no row is left: of {} rows {} have no value of a joint, {} more nothing measured",
          left_out.rows, left_out.without_joint, left_out.without_measured),
      hint.empty() ? "look at the map's columns" : hint};
}

UnitScale stated_scale(
    const MapColumn& column, const ImportTable& table, std::size_t at,
    std::vector<std::string>& notes) {
  if (column.is_text) return {};
  const StatedUnit stated = stated_unit(table, at);
  const auto tell = [&](const std::string& said) {
    notes.push_back(fmt::format("column {}: {}", column.from, said));
  };
  if (column.has_scale) {
    if (stated.unit == nullptr || column.unit.empty()) return {};
    const auto of_file = factor_of(column.to, *stated.unit);
    const auto of_map = factor_to(column.to, column.unit);
    if (!of_file || !of_map || std::abs(*of_file - *of_map) > 1e-9 * *of_map) {
      tell(fmt::format("{}, the map {}: the map counts", stated.from, column.unit));
    }
    return {};
  }
  for (const std::string& doubt : stated.doubts) tell(doubt);
  const std::string of_to = column.to.substr(column.to.rfind('_') + 1);
  if (!stated.unknown.empty() && find_import_unit(of_to) != nullptr) {
    tell(fmt::format(
        "{}: it is read in {}; if that is wrong, write unit or factor", stated.unknown, of_to));
  }
  if (stated.unit == nullptr) return {};
  const auto scale = scale_of(column.to, *stated.unit);
  if (!scale) {
    tell(fmt::format(
        "{}, which does not turn into {}: the numbers are taken as they are; look at from and "
        "to, or write factor",
        stated.from, column.to));
    return {};
  }
  if (scale->factor == 1.0 && scale->offset == 0.0) return {};
  if (!stated.certain) {
    tell(fmt::format(
        "{}, the map no unit: it is read in {}; if that is wrong, write unit = \"{}\"",
        stated.from, of_to, stated.unit->name));
    return {};
  }
  tell(fmt::format("{}: turned into {}", stated.from, of_to));
  return *scale;
}

}  // namespace sixdial::session
