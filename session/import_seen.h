// A column of somebody's table as the guess sees it: what its name speaks of, its values, and
// what the file says of its unit.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "session/import_names.h"
#include "session/import_table.h"
#include "session/import_units.h"

namespace sixdial::session {

/// Numbers of a column, and what else it holds; empty cells are not counted.
struct ColumnValues {
  double low = 0.0, high = 0.0;
  int numbers = 0, others = 0, times = 0;
  [[nodiscard]] double most() const;  // by amount
};
[[nodiscard]] ColumnValues values_of(const ImportTable& table, std::size_t column);

/// What the file says of a column's unit.
struct StatedUnit {
  const ImportUnit* unit = nullptr;  // null: nothing; may be of a kind that no session holds
  bool certain = false;              // by a row of units or in brackets, not by a name's ending
  std::string from{};                // "the row of units says deg"
  std::vector<std::string> doubts{};  // what contradicts it, in words
  /// What may be a unit and is none that is known, in words; empty: there is nothing.
  std::string unknown{};
};
[[nodiscard]] StatedUnit stated_unit(const ImportTable& table, std::size_t column);

struct SeenColumn {
  std::size_t column = 0;
  std::string name{};
  NameRole role{};
  ColumnValues values{};
  const ImportUnit* unit = nullptr;  // that the file states
  std::string unit_from{};           // by what it states it, in words
  std::vector<std::string> doubts{};
  [[nodiscard]] bool is_in(UnitKind kind) const {
    return unit != nullptr && unit->kind == kind;
  }
};
[[nodiscard]] std::vector<SeenColumn> seen_columns(const ImportTable& table);

inline constexpr double kMostMetres = 20.0;  // a place beyond it is given in millimetres

/// The unit that an angle is read in.
struct AngleUnit {
  std::string name;              // "deg"
  std::string why;               // by which sign
  bool guessed_radians = false;  // nothing says it, and degrees are possible, too
};
/// `most`: by amount, of all angles of the same kind in the file; one program writes them all
/// in one unit.
[[nodiscard]] AngleUnit angle_unit(const SeenColumn& column, double most);
/// "joint values up to 2.6: no unit is in the file; ..."
[[nodiscard]] std::string radians_or_degrees(std::string_view what, double most);

/// What one of `unit` is in the unit that the column of session.csv ends with; empty: it is of
/// another kind.
[[nodiscard]] std::optional<double> factor_of(const std::string& to, const ImportUnit& unit);

/// value = cell * factor + offset, in the unit of a column of session.csv.
struct UnitScale {
  double factor = 1.0;
  double offset = 0.0;
};
/// As factor_of, and of temperatures, too.
[[nodiscard]] std::optional<UnitScale> scale_of(const std::string& to, const ImportUnit& unit);

}  // namespace sixdial::session
