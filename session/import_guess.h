// Which column of somebody's table is most likely what, and by which sign: names
// (import_names.h), units that the file states, the size of the values, and, where the rig is
// known, its joints and what its instrument measures. What could be read otherwise is told.
//
//   const Guess guess = guess_columns(table, &layout);
//   guess.columns[0].to;    // "q1_rad"
//   guess.columns[0].unit;  // "deg"
//   guess.open;             // "joint values up to 2.6: no unit is in the file; ..."
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "session/import_table.h"
#include "session/sample_layout.h"

namespace sixdial::session {

struct GuessedColumn {
  std::size_t column = 0;  // of the table
  std::string to{};        // a column of session.csv
  std::string unit{};      // of the file; empty: that of `to`
  double factor = 1.0;     // besides the unit: of temperatures in K or degF
  double offset = 0.0;
  std::string why{};
};

struct Guess {
  std::vector<GuessedColumn> columns{};  // in the table's order
  std::map<std::size_t, std::string>
      left_out{};  // why a column that looks like something is not used
  /// What the file does not say and somebody has to look at; what is missing.
  std::vector<std::string> open{};
};

/// `layout` of the rig that the data are of; null: not known.
[[nodiscard]] Guess guess_columns(const ImportTable& table, const SampleLayout* layout);

/// The columns of session.csv that a session of this rig needs: every joint; what is measured.
[[nodiscard]] std::vector<std::string> needed_joints(const SampleLayout& layout);
[[nodiscard]] std::vector<std::string> needed_measured(const SampleLayout& layout);

/// The line of map.toml that takes this column.
[[nodiscard]] std::string map_lines(const ImportTable& table, const GuessedColumn& column);

/// "Nr, Zeit, J1, ...": names of the table's columns, cut to a readable length.
[[nodiscard]] std::string names_in_words(const ImportTable& table);

}  // namespace sixdial::session
