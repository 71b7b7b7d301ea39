#include "session/import_seen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "session/import.h"
#include "session/import_time.h"

namespace sixdial::session {
namespace {

constexpr double kMostTurns_rad = 7.0;  // a joint beyond it is given in degrees

}  // namespace

double ColumnValues::most() const { return std::max(std::abs(low), std::abs(high)); }

ColumnValues values_of(const ImportTable& table, std::size_t column) {
  ColumnValues values;
  for (const auto& row : table.rows) {
    const std::string& cell = row[column];
    if (cell.empty()) continue;
    if (time_in(cell, table.decimal_of(column))) ++values.times;
    const auto number = number_in(cell, table.decimal_of(column));
    if (!number || !std::isfinite(*number)) {
      ++values.others;
      continue;
    }
    const bool first = values.numbers++ == 0;
    values.low = first ? *number : std::min(values.low, *number);
    values.high = first ? *number : std::max(values.high, *number);
  }
  return values;
}

StatedUnit stated_unit(const ImportTable& table, std::size_t column) {
  StatedUnit stated;
  const NameWithUnit in_name = unit_in_name(table.names[column]);
  std::string in_row = table.units.empty() ? "" : table.units[column];
  if (in_row == "-" || in_row == "1") in_row.clear();  // without a unit
  for (const std::string& text : {in_row, in_name.text}) {
    if (is_doubtful_unit(text)) {
      stated.doubts.emplace_back(
          "'grad' is the degree in German and gon elsewhere: write unit = \"deg\" or \"gon\"");
    }
  }
  const ImportUnit* of_row = find_import_unit(in_row);
  if (of_row != nullptr) {
    stated.unit = of_row;
    stated.certain = true;
    stated.from = "the row of units says " + in_row;
    if (in_name.unit != nullptr && in_name.unit != of_row) {
      stated.doubts.push_back(fmt::format(
          "its name says {}, the row of units {}: {} is taken", in_name.text, in_row, in_row));
    }
  } else if (in_name.unit != nullptr) {
    stated.unit = in_name.unit;
    stated.certain = in_name.certain;
    stated.from = fmt::format("its name says {}", in_name.text);
  } else if (!in_row.empty()) {
    stated.unknown =
        fmt::format("the row of units says {}, which is no unit that is known", in_row);
  } else if (!in_name.unknown.empty() && !are_words_of_names(in_name.unknown)) {
    stated.unknown = fmt::format(
        "its name ends with {}, which may be a unit and is not used", in_name.unknown);
  }
  if (is_doubtful_unit(in_row) || is_doubtful_unit(in_name.text)) stated.unit = nullptr;
  return stated;
}

namespace {

bool is_of_session(const SeenColumn& each) {
  const NameRole::What what = each.role.what;
  return each.values.numbers > 0 &&
         (what == NameRole::What::kJoint || what == NameRole::What::kPlace ||
          what == NameRole::What::kTurn || what == NameRole::What::kTemperature);
}

/// Units that the values speak against.
void doubt_by_size(const SeenColumn& each, StatedUnit& stated) {
  constexpr double kManyTurns_rad = 30.0;
  if (stated.unit == nullptr) return;
  if (stated.unit->name == "rad" && each.values.most() > kManyTurns_rad) {
    stated.doubts.push_back(fmt::format(
        "{}, but values up to {:.4g} are many turns: are they degrees?", stated.from,
        each.values.most()));
  }
  const bool ending = stated.unit->name == "m" && !stated.certain;
  if (ending && is_of_session(each) && each.values.most() > kMostMetres) {
    stated.doubts.push_back(fmt::format(
        "{}, but values up to {:.4g} are far for metres: are they millimetres, and m a word?",
        stated.from, each.values.most()));
  }
}

/// "orientation.x", ".y", ".z" beside "orientation.w" are no angles: a quaternion of ROS.
void find_quaternions(std::vector<SeenColumn>& all) {
  std::map<std::string, std::map<std::string, SeenColumn*>> turns;
  for (SeenColumn& each : all) {
    const auto part = turn_letter_of(each.name);
    const bool free =
        each.role.what == NameRole::What::kTurn || each.role.what == NameRole::What::kNothing;
    if (part && free) turns[part->stem].emplace(part->letter, &each);
  }
  for (const auto& [stem, letters] : turns) {
    if (letters.size() < 4) continue;
    for (const auto& [letter, each] : letters) {
      each->role.what = NameRole::What::kQuaternion;
      each->role.key = "q" + letter;
    }
  }
}

}  // namespace

std::vector<SeenColumn> seen_columns(const ImportTable& table) {
  std::vector<SeenColumn> all;
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    SeenColumn& each = all.emplace_back();
    each.column = k;
    each.name = table.names[k];
    each.role = role_of(each.name);
    each.values = values_of(table, k);
    StatedUnit stated = stated_unit(table, k);
    doubt_by_size(each, stated);
    if (!stated.unknown.empty() && is_of_session(each)) {
      stated.doubts.push_back(
          stated.unknown + ": write unit, or factor, into the map if it is one");
    }
    each.unit = stated.unit;
    each.unit_from = std::move(stated.from);
    each.doubts = std::move(stated.doubts);
  }
  find_quaternions(all);
  return all;
}

AngleUnit angle_unit(const SeenColumn& column, double most) {
  if (column.is_in(UnitKind::kAngle)) {
    return {std::string(column.unit->name), column.unit_from};
  }
  const bool degrees = most > kMostTurns_rad;
  return {
      degrees ? "deg" : "rad",
      fmt::format("values up to {:.4g} are {}", most, degrees ? "degrees" : "radians"),
      !degrees};
}

std::string radians_or_degrees(std::string_view what, double most) {
  return fmt::format(
      "{} up to {:.4g}: no unit is in the file; they are taken as radians, and could be small "
      "angles in degrees: look at unit",
      what, most);
}

std::optional<double> factor_of(const std::string& to, const ImportUnit& unit) {
  return factor_to(to, unit.name);
}

std::optional<UnitScale> scale_of(const std::string& to, const ImportUnit& unit) {
  if (const auto factor = factor_of(to, unit)) return UnitScale{*factor, 0.0};
  if (to != "temperature_c" || unit.kind != UnitKind::kTemperature) return std::nullopt;
  return UnitScale{unit.in_stored, unit.offset};
}

}  // namespace sixdial::session
