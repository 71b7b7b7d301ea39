#include "session/import_table.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "session/csv.h"
#include "session/data_error.h"
#include "session/import_time.h"
#include "session/import_units.h"

namespace sixdial::session {
namespace {

constexpr std::array kSeparators{';', '\t', '|', ',', ' '};
constexpr std::size_t kJudged = 50;  // lines that say what the format is
constexpr std::size_t kMostCells = 20'000'000;

std::string_view stripped(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}
std::string_view trimmed(std::string_view text) { return stripped(text, " \t\r"); }
std::string_view without_blanks_at_ends(std::string_view line) { return stripped(line, " \r"); }

/// UTF-8 without a byte order mark; UTF-16 with one is turned into it.
std::string as_text(std::string_view bytes, std::vector<std::string>& notes) {
  if (bytes.starts_with("\xEF\xBB\xBF")) {
    notes.emplace_back("a byte order mark at the beginning was left out");
    bytes.remove_prefix(3);
  }
  const bool little = bytes.starts_with("\xFF\xFE");
  if (!little && !bytes.starts_with("\xFE\xFF")) {
    std::string text = as_utf8(bytes);
    if (text != bytes) notes.emplace_back("letters that are no UTF-8 were replaced by '?'");
    return text;
  }
  notes.emplace_back("the file is UTF-16");
  std::string text;
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const auto low = static_cast<unsigned char>(bytes[little ? i : i + 1]);
    const auto high = static_cast<unsigned char>(bytes[little ? i + 1 : i]);
    text += high == 0 && low < 0x80 ? static_cast<char>(low) : '?';
  }
  return text;
}

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cell += line[++i];
      } else {
        quoted = !quoted;
      }
    } else if (c == separator && !quoted) {
      // Several blanks are one separator.
      if (separator != ' ' || !cell.empty()) cells.push_back(std::exchange(cell, ""));
    } else {
      cell += c;
    }
  }
  if (separator != ' ' || !cell.empty()) cells.push_back(std::move(cell));
  for (std::string& each : cells) each = std::string(trimmed(each));
  return cells;
}

struct Line {
  std::string_view text;
  int number = 0;
};

std::vector<Line> lines_of(std::string_view text, int skip) {
  std::vector<Line> lines;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    const std::string_view seen = trimmed(line);
    ++number;
    if (number > skip && !seen.empty() && !seen.starts_with('#')) {
      // A tab at an end of the line stands beside an empty cell.
      lines.push_back({without_blanks_at_ends(line), number});
    }
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
  return lines;
}

/// The separator that gives most lines the same number of cells, at least two.
char separator_of(const std::vector<Line>& lines) {
  char best = ',';
  std::size_t most = 0;
  for (const char separator : kSeparators) {
    std::map<std::size_t, std::size_t> counts;
    const std::size_t judged = std::min(lines.size(), kJudged);
    for (std::size_t i = 0; i < judged; ++i) {
      ++counts[cells_of(lines[i].text, separator).size()];
    }
    for (const auto& [cells, times] : counts) {
      if (cells < 2 || times * 2 < judged) continue;  // some rows may be damaged
      if (most == 0) {  // the order of kSeparators decides: a comma may be a decimal comma
        most = times;
        best = separator;
      }
    }
  }
  return best;
}

/// More cells are numbers with a comma than with a point.
char decimal_of(const std::vector<Line>& lines, char separator) {
  if (separator == ',') return '.';
  int commas = 0;
  int points = 0;
  for (std::size_t i = 0; i < std::min(lines.size(), kJudged); ++i) {
    for (const std::string& cell : cells_of(lines[i].text, separator)) {
      const bool comma = cell.find(',') != std::string::npos;
      const bool point = cell.find('.') != std::string::npos;
      if (comma && number_in(cell, ',')) ++commas;
      if (point && number_in(cell, '.')) ++points;
    }
  }
  return commas > points ? ',' : '.';
}

/// "2026-11-30", "10:09:25" are one time stamp, where blanks separate the columns.
bool join_time(std::vector<std::string>& cells) {
  for (std::size_t i = 0; i + 1 < cells.size(); ++i) {
    if (!is_date_alone(cells[i]) || !is_time_of_day(cells[i + 1])) continue;
    cells[i] += ' ' + cells[i + 1];
    cells.erase(cells.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    return true;
  }
  return false;
}

/// Lines of a text as rows of as many cells as there are names.
class TextTable {
 public:
  TextTable(ImportTable& table, char separator) : table_(table), separator_(separator) {}

  /// True: the line was one of names.
  bool header(const Line& line, std::optional<bool> is_header) {
    std::vector<std::string> cells = cells_of(line.text, separator_);
    const bool numbers = std::ranges::all_of(cells, [&](const std::string& cell) {
      return cell.empty() || number_in(cell, table_.decimal) || time_in(cell, table_.decimal) ||
             is_date_alone(cell) || is_time_of_day(cell);
    });
    has_header_ = is_header.value_or(!numbers);
    if (!has_header_ && separator_ == ' ') join_time(cells);
    if (!is_header) {
      table_.notes.emplace_back(
          has_header_ ? "the first line has names"
                      : "there is no header: columns are named 1, 2, ...");
    }
    for (const std::string& cell : cells) {
      unnamed_ = has_header_ && cell.empty() ? unnamed_ + 1 : 0;
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      table_.names.push_back(
          has_header_ && !cells[i].empty() ? cells[i] : std::to_string(i + 1));
    }
    return has_header_;
  }

  /// True: the line beneath the header was one of units. Without being told, it is taken for
  /// one where no cell is a number and one at least is the unit of a length or an angle.
  bool units(const Line& line, std::optional<bool> is_units) {
    std::vector<std::string> cells = cells_of(line.text, separator_);
    while (cells.size() > table_.names.size() && cells.back().empty()) cells.pop_back();
    cells.resize(std::max(cells.size(), table_.names.size()));
    if (!is_units) {
      if (cells.size() != table_.names.size()) return false;
      std::size_t of_session = 0;
      std::size_t known = 0;
      std::size_t others = 0;
      for (const std::string& cell : cells) {
        if (cell.empty()) continue;
        if (number_in(cell, table_.decimal) && cell != "1") return false;
        const ImportUnit* unit = find_import_unit(cell);
        (unit == nullptr ? others : known) += 1;
        const bool measures = unit != nullptr && (unit->kind == UnitKind::kLength ||
                                                  unit->kind == UnitKind::kAngle);
        of_session += measures ? 1U : 0U;
      }
      if (of_session == 0 || others > known) return false;
    }
    cells.resize(table_.names.size());
    std::string list;
    for (const std::string& cell : cells) {
      if (!cell.empty() && list.size() < kMostListed) list += (list.empty() ? "" : ", ") + cell;
    }
    table_.notes.push_back(fmt::format(
        "line {} is a row of units ({}), not of values", line.number,
        list.empty() ? "all empty" : list));
    table_.units = std::move(cells);
    return true;
  }

  void row(const Line& line) {
    std::vector<std::string> cells = cells_of(line.text, separator_);
    while (cells.size() > table_.names.size() && cells.back().empty()) cells.pop_back();
    const std::size_t named = table_.names.size() - unnamed_;
    if (cells.size() >= named) cells.resize(std::max(cells.size(), table_.names.size()));
    const bool one_more = cells.size() == table_.names.size() + 1;
    if (separator_ == ' ' && one_more && join_time(cells)) ++joined_;
    if (cells.size() != table_.names.size()) {
      if (odd_++ == 0) first_odd_ = line.number;
      return;
    }
    table_.rows.push_back(std::move(cells));
    table_.lines.push_back(line.number);
  }

  void tell() {
    if (joined_ > 0) {
      table_.notes.push_back(fmt::format(
          "blanks separate the columns: date and time of {} {} were taken for one column",
          joined_, joined_ == 1 ? "row" : "rows"));
    }
    if (odd_ == 0) return;
    table_.notes.push_back(fmt::format(
        "{} {} not {} columns and {} left out, the first in line {}", odd_,
        odd_ == 1 ? "row has" : "rows have", table_.names.size(), odd_ == 1 ? "is" : "are",
        first_odd_));
  }

 private:
  static constexpr std::size_t kMostListed = 80;  // characters of a list of units

  ImportTable& table_;
  char separator_;
  bool has_header_ = false;
  std::size_t unnamed_ = 0;  // columns at the end that the header has no name for
  int joined_ = 0;
  int odd_ = 0;
  int first_odd_ = 0;
};

ImportTable text_table(
    const std::string& text, const std::string& file, const TableFormat& format,
    std::vector<std::string> notes) {
  ImportTable table{.file = file, .notes = std::move(notes)};
  const std::vector<Line> lines = lines_of(text, format.skip_lines);
  if (lines.empty()) {
    throw DataError(file, Mistake{1, 1, "", "the file has no lines", "give a table"});
  }
  const char separator = format.separator.value_or(separator_of(lines));
  table.decimal = format.decimal.value_or(decimal_of(lines, separator));
  if (!format.separator || !format.decimal) {
    table.notes.push_back(fmt::format(
        "read with separator {} and decimal {}",
        separator == '\t'  ? std::string("tab")
        : separator == ' ' ? std::string("' ' (blanks)")
                           : fmt::format("'{}'", separator),
        table.decimal == ',' ? "comma" : "point"));
  }
  TextTable rows(table, separator);
  std::size_t next = rows.header(lines[0], format.header) ? 1 : 0;
  const bool may_have_units = format.units_row.value_or(next == 1);
  if (may_have_units && next < lines.size() && rows.units(lines[next], format.units_row)) {
    ++next;
  }
  for (; next < lines.size(); ++next) rows.row(lines[next]);
  rows.tell();
  return table;
}

/// "pose.x" -> "0.5", "target_joints.0" -> "1.2": every value of a record by its path. An alias
/// of YAML may stand for what holds it, or for so much that no memory is enough: there is a
/// limit to both.
class Record {
 public:
  explicit Record(const std::string& file) : file_(file) {}

  void add(const std::string& path, const std::string& value) {
    if (cells_.emplace(path, value).second) order_.push_back(path);
  }

  void flatten(const YAML::Node& node, const std::string& path, int depth = 0) {
    constexpr int kMostDepth = 64;
    constexpr int kMostNodes = 10'000;
    if (depth > kMostDepth || ++nodes_ > kMostNodes) {
      throw DataError(
          file_, Mistake{
                     node.Mark().line + 1, node.Mark().column + 1, "",
                     fmt::format(
                         "a record is nested deeper than {} or holds more than {} values",
                         kMostDepth, kMostNodes),
                     "give a list of records, each of a few values"});
    }
    const auto below = [&](const std::string& key) {
      return path.empty() ? key : path + '.' + key;
    };
    if (node.IsMap()) {
      for (const auto& each : node) {
        flatten(each.second, below(each.first.as<std::string>()), depth + 1);
      }
    } else if (node.IsSequence()) {
      for (std::size_t i = 0; i < node.size(); ++i) {
        flatten(node[i], below(std::to_string(i)), depth + 1);
      }
    } else if (node.IsScalar()) {
      add(path, node.Scalar());
    }
  }

  [[nodiscard]] const std::vector<std::string>& order() const { return order_; }
  [[nodiscard]] std::map<std::string, std::string> take() { return std::move(cells_); }

 private:
  const std::string& file_;
  std::map<std::string, std::string> cells_;
  std::vector<std::string> order_;
  int nodes_ = 0;
};

/// A list of records, or a map whose keys name them (kept as the column "key").
ImportTable yaml_table(const std::string& text, const std::string& file) {
  ImportTable table{.file = file};
  std::vector<std::map<std::string, std::string>> records;
  std::vector<std::string> seen;
  std::set<std::string> known;
  try {
    const YAML::Node top = YAML::Load(text);
    if (!top.IsSequence() && !top.IsMap()) {
      throw DataError(
          file, Mistake{1, 1, "", "the YAML is no list and no map of records", "give one"});
    }
    for (const auto& each : top) {
      const bool named = top.IsMap();
      Record record(file);
      if (named) {
        record.add("key", each.first.as<std::string>());
        record.flatten(each.second, "");
      } else {
        record.flatten(each, "");
      }
      for (const std::string& name : record.order()) {
        if (known.insert(name).second) seen.push_back(name);
      }
      records.push_back(record.take());
      if (records.size() * seen.size() > kMostCells) {
        throw DataError(file, Mistake{1, 1, "", "the YAML is too large", "split it"});
      }
    }
  } catch (const YAML::Exception& error) {
    throw DataError(
        file, Mistake{
                  error.mark.line + 1, error.mark.column + 1, "", std::string(error.msg),
                  "mend the YAML there"});
  }
  table.names = std::move(seen);
  for (const auto& cells : records) {
    auto& row = table.rows.emplace_back();
    for (const std::string& name : table.names) {
      const auto at = cells.find(name);
      row.push_back(at == cells.end() ? "" : at->second);
    }
    table.lines.push_back(0);
  }
  if (table.rows.empty()) {
    throw DataError(file, Mistake{1, 1, "", "the YAML has no records", "give some"});
  }
  if (table.names.empty()) {
    throw DataError(
        file, Mistake{
                  1, 1, "", "the records of the YAML hold no values",
                  "give a list of records, such as - {J1: 10.5, x: 100}"});
  }
  return table;
}

bool is_yaml(const std::string& file, const TableFormat& format) {
  if (format.kind != TableFormat::Kind::kByName) {
    return format.kind == TableFormat::Kind::kYaml;
  }
  return file.ends_with(".yaml") || file.ends_with(".yml");
}

}  // namespace

std::optional<double> number_in(std::string_view cell, char decimal) {
  std::string text(cell);
  if (decimal == ',') {
    if (text.find('.') != std::string::npos) return std::nullopt;
    std::ranges::replace(text, ',', '.');
  }
  const ParsedNumber number = parse_number(text);
  if (number.trouble) return std::nullopt;
  return number.value;
}

ImportTable read_table(
    std::string_view bytes, const std::string& file, const TableFormat& format) {
  std::vector<std::string> notes;
  const std::string text = as_text(bytes, notes);
  return is_yaml(file, format) ? yaml_table(text, file)
                               : text_table(text, file, format, std::move(notes));
}

}  // namespace sixdial::session
