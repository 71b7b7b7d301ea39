// Tables as people have them: text with any separator, decimal commas, a byte order mark, lines
// above the header, units below it, or none of these; YAML as a list or a map of records. All
// of it becomes one table of names and cells; what was odd is told.
//
//   const ImportTable table = read_table(read_file(name), name, {});
//   table.names[0];    // "shoulder_pan_joint", "pose.x", or "1" where there is no header
//   table.rows[0][0];  // the cell as it stands in the file
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::session {

struct TableFormat {
  enum class Kind { kByName, kText, kYaml };
  Kind kind = Kind::kByName;
  std::optional<char> separator{};  // empty: found out
  std::optional<char> decimal{};    // '.' or ','; empty: found out
  std::optional<bool> header{};     // empty: found out
  int skip_lines = 0;               // above the header
  std::optional<bool> units_row{};  // one line below it; empty: found out
};

struct ImportTable {
  std::string file{};
  std::vector<std::string> names{};
  std::vector<std::vector<std::string>> rows{};  // each as long as `names`
  std::vector<int> lines{};  // of the file, from 1; 0: a record of a YAML file
  /// What a row of units beneath the header says of each column, as it stands there; none at
  /// all: there is no such row.
  std::vector<std::string> units{};
  char decimal = '.';
  /// Of each column, where tables beside each other do not agree; none at all: `decimal`.
  std::vector<char> decimals{};
  std::vector<std::string> notes{};  // what was found out, and what was odd

  [[nodiscard]] char decimal_of(std::size_t column) const {
    return decimals.empty() ? decimal : decimals[column];
  }
};

/// Throws DataError where the text is no table at all.
[[nodiscard]] ImportTable read_table(
    std::string_view text, const std::string& file, const TableFormat& format);

/// The columns of one table or more beside each other, row by row; a name that appears again
/// is "2:name". Throws DataError where they have not the same number of rows.
[[nodiscard]] ImportTable beside(std::vector<ImportTable> tables);

/// A cell as a number; empty: it is none.
[[nodiscard]] std::optional<double> number_in(std::string_view cell, char decimal);

}  // namespace sixdial::session
