// A page as a tree of sections, tables and figures, before it is HTML, JSON or CSV. Every part
// of the project that has something to show hands over sections; only html_report.cpp knows
// markup.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace sixdial::report {

/// A number with the decimals it is shown with. JSON and CSV always give it in full, and
/// without `shown_times`. Not finite: shown as a dash, JSON null, CSV empty.
struct Number {
  double value = 0.0;
  int decimals = 4;
  double shown_times = 1.0;  // a page shows this times the value: 2 of an expanded uncertainty
};
/// Nothing, a text or a number.
using Cell = std::variant<std::monostate, std::string, Number>;

[[nodiscard]] inline Cell number(double value, int decimals = 4) {
  return Number{value, decimals};
}
[[nodiscard]] inline Cell number(const std::optional<double>& value, int decimals = 4) {
  return value ? Cell{Number{*value, decimals}} : Cell{};
}
[[nodiscard]] inline Cell whole(long long value) {
  return Number{static_cast<double>(value), 0};
}

struct Column {
  std::string key{};    // in CSV and JSON, with its unit: "mean_mm"
  std::string title{};  // above the column: "mean"
  std::string unit{};   // under the title: "mm"; empty: a text, a count, or the cells say it
  std::string group{};  // neighbours of one group share a heading: "G1 calibration"
};

/// A column by its parts; `unit` and `group` may be left out.
[[nodiscard]] inline Column column(
    std::string key, std::string title, std::string unit = "", std::string group = "") {
  return {
      .key = std::move(key),
      .title = std::move(title),
      .unit = std::move(unit),
      .group = std::move(group)};
}
/// A text as a cell; an empty one is shown as a dash.
[[nodiscard]] inline Cell text_cell(const std::string& text) {
  return text.empty() ? Cell{} : Cell{text};
}

struct Table {
  std::string id{};  // in CSV file names and anchors: lower-case letters, digits, '_'
  std::string caption{};
  std::vector<Column> columns{};
  std::vector<std::vector<Cell>> rows{};
  std::vector<std::string> notes{};       // under the table
  std::optional<std::size_t> main_row{};  // printed bold
  /// A table with more rows than this is shown by its first rows, half as many as this, and a
  /// line that says where the others are.
  std::size_t rows_on_page = 200;
};

struct Axis {
  std::string label{};  // "position error"
  std::string unit{};   // "mm"
  bool logarithmic = false;
  bool square_root = false;             // gives the first steps of a long run more room
  std::optional<double> low{}, high{};  // else from the data
};

enum class Mark {
  kLine,
  kStep,  // holds its value up to the next point
  kDots,
  kLineAndDots,
  kArrows,      // from (x, y) by (dx, dy) times the panel's arrow scale
  kRuleAcross,  // horizontal at each y
  kRuleUp,      // vertical at each x
  kBand,        // between y and high
  kBars,        // from 0 to y at each x
};

struct Series {
  std::string name{};  // in the legend, if not empty
  Mark mark = Mark::kLine;
  int style = 0;  // 0..7: colour and symbol; the same number is the same thing in all charts
  std::vector<double> x{}, y{};
  std::vector<double> dx{}, dy{}, high{};
  std::string label{};  // written beside the last point or on the rule
};

struct Panel {
  std::string title{};
  Axis x{}, y{};
  std::vector<Series> series{};
  bool equal_scales = false;  // 1 mm across is 1 mm up
  double arrow_scale = 1.0;   // arrows are drawn this many times too long
  double arrow_key = 0.0;     // length of the arrow that is drawn as a key, 0 for none
};

struct Chart {
  std::vector<Panel> panels{};
  int panels_in_a_row = 1;
  int panel_height = 260;  // pixels; not used where scales are equal
};

/// A figure always says what it shows, what good looks like, and what this session has, and
/// carries its numbers as a table, which is what a reader without JavaScript gets.
struct Figure {
  std::string id{};
  std::string title{};
  std::string shows{}, good{}, here{};
  Chart chart{};
  Table table{};
};

/// A drawing that needs no script. `svg` goes into the page as it is: whoever makes it escapes
/// what it holds. Its numbers stand in a table beside it.
struct Picture {
  std::string id{};
  std::string title{};
  std::string shows{};
  std::string svg{};
};

using Block = std::variant<std::string, Table, Figure, Picture>;  // a string is a paragraph

struct Section {
  std::string id{};
  std::string heading{};
  std::vector<Block> blocks{};
  bool in_annex = false;  // details that only some readers need: behind everything else
};

}  // namespace sixdial::report
