// What a map has to give, and what to say where it does not: which columns the file has, which
// of the session are missing, and the lines of map.toml that would help.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/data_error.h"
#include "session/import.h"
#include "session/import_seen.h"
#include "session/sample_layout.h"

namespace sixdial::session {

/// Whether a column of session.csv is something that was measured.
[[nodiscard]] bool is_measured(const std::string& to);

/// The joints (`missing`: their columns) that no [[column]] gives.
[[nodiscard]] Mistake joints_missing(
    const std::vector<std::string>& missing, const ImportMap& map, const SampleLayout& layout,
    const ImportTable& table);

/// Empty: the map gives something measured.
[[nodiscard]] std::optional<Mistake> nothing_measured(
    const ImportMap& map, const SampleLayout& layout, const ImportTable& table);

/// Why rows were left out.
struct RowsLeftOut {
  std::size_t rows = 0;  // read, left out or not
  std::size_t without_joint = 0;
  std::size_t without_measured = 0;     // with all joints
  std::vector<std::size_t> no_value{};  // by column of the map: rows without a value
  std::vector<std::string> odd{};       // what cells could not be read as
};
[[nodiscard]] Mistake no_row_left(const ImportMap& map, const RowsLeftOut& left_out);

/// How a column that the map gives no unit is turned into that of its `to`, from what the file
/// says of it: its row of units, or brackets in its name. `notes`: what was taken, contradicts
/// the map, or cannot be turned.
[[nodiscard]] UnitScale stated_scale(
    const MapColumn& column, const ImportTable& table, std::size_t at,
    std::vector<std::string>& notes);

}  // namespace sixdial::session
