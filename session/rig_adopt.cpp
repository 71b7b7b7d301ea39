#include "session/rig_adopt.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>

#include "session/csv.h"
#include "session/data_error.h"
#include "session/rig_file.h"

namespace sixdial::session {
namespace {

constexpr int kDigits = 6;

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1);
    lines.emplace_back(text.substr(0, end + 1));  // its end included
    text.remove_prefix(end + 1);
  }
  return lines;
}

std::string without_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string_view::npos ? "" : std::string(text.substr(first));
}

/// "d_mm" of "  d_mm = 90.0  # drawing"; empty: no such line.
std::string key_of(std::string_view line) {
  const std::string text = without_blanks(line);
  const std::size_t equals = text.find('=');
  if (text.empty() || text[0] == '#' || text[0] == '[' || equals == std::string::npos)
    return "";
  std::string key = text.substr(0, equals);
  key.erase(key.find_last_not_of(" \t") + 1);
  return key;
}

std::string note_of(const AdoptedFigure& figure, const std::string& from) {
  if (!(figure.sd > 0.0)) return "";
  return fmt::format("# +- {:.{}f} (k = 2), found by {}", 2.0 * figure.sd, kDigits, from);
}

std::string value_of(const AdoptedFigure& figure) {
  if (figure.value.size() == 1) return fmt::format("{:.{}f}", figure.value[0], kDigits);
  std::string list;
  for (const double each : figure.value) {
    list += fmt::format("{}{:.{}f}", list.empty() ? "" : ", ", each, kDigits);
  }
  return "[" + list + "]";
}

/// The same line with another value; what an earlier adoption noted goes, other comments stay.
std::string changed(
    const std::string& line, const AdoptedFigure& figure, const std::string& from) {
  const std::size_t equals = line.find('=');
  const std::size_t comment = line.find('#', equals);
  const std::string end = line.ends_with("\r\n") ? "\r\n" : line.ends_with('\n') ? "\n" : "";
  std::string kept;
  if (comment != std::string::npos) {
    kept = line.substr(comment, line.size() - comment - end.size());
    const std::size_t earlier = kept.find("# +- ");
    if (earlier != std::string::npos) kept.erase(earlier);
    kept.erase(kept.find_last_not_of(" \t\r") + 1);
  }
  const std::string note = note_of(figure, from);
  const std::string behind = kept + (kept.empty() || note.empty() ? "" : "  ") + note;
  return fmt::format(
      "{} {}{}{}{}", line.substr(0, equals + 1), value_of(figure), behind.empty() ? "" : "   ",
      behind, end);
}

/// "A" of a line `id = "A"`; empty: it is another one.
std::string id_of(const std::string& line) {
  if (key_of(line) != "id") return "";
  const std::size_t open = line.find_first_of("\"'");
  if (open == std::string::npos) return "";
  return line.substr(open + 1, line.find(line[open], open + 1) - open - 1);
}

/// Lines [first, last) of the figure's table, without its head; empty: there is no such table.
std::pair<std::size_t, std::size_t> lines_of_table(
    const std::vector<std::string>& lines, const AdoptedFigure& figure) {
  const std::string head = figure.dial.empty() ? "[" + figure.table + "]" : "[[dial]]";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!without_blanks(lines[i]).starts_with(head)) continue;
    std::size_t last = i + 1;
    bool is_it = figure.dial.empty();
    while (last < lines.size() && !without_blanks(lines[last]).starts_with('[')) {
      is_it = is_it || id_of(lines[last]) == figure.dial;
      ++last;
    }
    if (is_it) return {i + 1, last};
  }
  return {lines.size(), lines.size()};
}

/// What the file says of it now.
std::vector<double> value_in(const toml::table& top, const AdoptedFigure& figure) {
  const toml::node* node = nullptr;
  if (figure.dial.empty()) {
    node = top[figure.table][figure.key].node();
  } else if (const toml::array* dials = top["dial"].as_array()) {
    for (const toml::node& each : *dials) {
      const toml::table* dial = each.as_table();
      if (dial != nullptr && (*dial)["id"].value<std::string>() == figure.dial) {
        node = dial->get(figure.key);
      }
    }
  }
  std::vector<double> value;
  if (node == nullptr) return value;
  if (const auto one = node->value<double>()) return {*one};
  if (const toml::array* list = node->as_array()) {
    for (const toml::node& each : *list) value.push_back(each.value<double>().value_or(0.0));
  }
  return value;
}

}  // namespace

std::string with_adopted(
    std::string_view rig_text, const std::string& file_name,
    const std::vector<AdoptedFigure>& figures, const std::string& from) {
  std::vector<std::string> lines = lines_of(rig_text);
  if (!lines.empty() && !lines.back().ends_with('\n')) lines.back() += '\n';
  for (const AdoptedFigure& figure : figures) {
    const auto [first, last] = lines_of_table(lines, figure);
    std::size_t at = first;
    std::size_t after = first;  // behind the last key of the table
    while (at < last && key_of(lines[at]) != figure.key) {
      if (!key_of(lines[at]).empty()) after = at + 1;
      ++at;
    }
    if (at < last) {
      lines[at] = changed(lines[at], figure, from);
    } else {
      lines.insert(
          lines.begin() + static_cast<std::ptrdiff_t>(after),
          fmt::format("{} = {}   {}\n", figure.key, value_of(figure), note_of(figure, from)));
    }
  }
  std::string text;
  for (const std::string& line : lines) text += line;
  static_cast<void>(parse_rig(text, file_name));
  const toml::table top = toml::parse(text);
  for (const AdoptedFigure& figure : figures) {
    std::vector<double> rounded = figure.value;
    for (double& each : rounded) each = rounded_decimal(each, kDigits);
    if (value_in(top, figure) == rounded) continue;
    throw DataError(
        file_name, Mistake{
                       0, 0, figure.key, "cannot be changed in this file",
                       "write [robot], [cuboid] and each [[dial]] as tables of their own, one "
                       "key a line"});
  }
  return text;
}

}  // namespace sixdial::session
