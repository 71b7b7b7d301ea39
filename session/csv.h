// Comma-separated text as people and spreadsheets write it: RFC 4180 quoting, LF or CRLF, a
// byte order mark, with or without a last line end. Keeps each row's own bytes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "session/data_error.h"

namespace sixdial::session {

struct CsvField {
  std::string value;  // without quotes
  int column = 1;     // of its first character in the line, from 1
};

struct CsvRow {
  int line = 1;
  std::string_view text;  // as it stands in the file, without the table's line end
  std::vector<CsvField> fields;
  std::optional<Mistake> fault;  // quoting that cannot be read
};

/// A header and its rows; views point into the text given to `read_csv`.
struct CsvTable {
  CsvRow header;
  std::vector<CsvRow> rows;  // without blank lines at the end of the file
  std::string line_end;      // "\r\n" if every line ends so, else "\n"
  std::string end;           // what follows the last row
};

/// Throws DataError for text that is no table at all: empty, not UTF-8, NUL characters.
/// `text` must outlive the table.
[[nodiscard]] CsvTable read_csv(std::string_view text, const std::string& file_name);

/// The value in quotes for a message, cut to a readable length.
[[nodiscard]] std::string shown(std::string_view value);

/// Quoted if it holds a comma, a quote or a line end.
[[nodiscard]] std::string csv_field(std::string_view value);

enum class NumberTrouble { kEmpty, kNotANumber, kNotFinite };
/// A mistake for a number field, in words for the person who wrote the file.
[[nodiscard]] Mistake number_mistake(
    const CsvRow& row, const CsvField& field, const std::string& name, NumberTrouble trouble);

struct ParsedNumber {
  double value = 0.0;
  std::optional<NumberTrouble> trouble;
};
/// The whole field as a decimal number; blanks around it and a leading + are tolerated.
[[nodiscard]] ParsedNumber parse_number(std::string_view text);
/// The whole field as an integer.
[[nodiscard]] std::optional<int> parse_integer(std::string_view text);

/// Decimal text with at least `least_digits` after the point, more (to 9) where fewer would
/// change the value by over 1e-10.
[[nodiscard]] std::string decimal(double value, int least_digits);

/// Rounded to a number of digits after the point, as a double.
[[nodiscard]] double rounded_decimal(double value, int digits);

/// The text with every byte that is no UTF-8 character, and NUL, as '?': what a device sent may
/// be anything, and JSON and databases want text.
[[nodiscard]] std::string as_utf8(std::string_view bytes);

/// Whole file as bytes. Throws DataError if it cannot be read, or is no plain file; what a
/// shell hands over, such as <(command), may be a pipe.
[[nodiscard]] std::string read_file(const std::string& path);
/// Writes beside and renames over, so a reader sees the old file or the new one; of a link the
/// file that it points to. Throws DataError, also for what is no plain file.
void write_file(const std::string& path, std::string_view text);

}  // namespace sixdial::session
