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
  return fmt::format("# +- {:.{}f} (k = 2), found by {}", 2.0 * figure.sd, kDigits, from);
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
  return fmt::format(
      "{} {:.{}f}   {}{}{}{}", line.substr(0, equals + 1), figure.value, kDigits, kept,
      kept.empty() ? "" : "  ", note_of(figure, from), end);
}

/// The first and last-but-one line of [robot]: those between its head and the next table.
std::pair<std::size_t, std::size_t> robot_lines(const std::vector<std::string>& lines) {
  std::size_t first = lines.size();
  std::size_t last = lines.size();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string text = without_blanks(lines[i]);
    if (first == lines.size()) {
      if (text.starts_with("[robot]")) first = i + 1;
    } else if (text.starts_with('[')) {
      last = i;
      break;
    }
  }
  return {first, last};
}

}  // namespace

std::string with_adopted(
    std::string_view rig_text, const std::string& file_name,
    const std::vector<AdoptedFigure>& figures, const std::string& from) {
  std::vector<std::string> lines = lines_of(rig_text);
  for (const AdoptedFigure& figure : figures) {
    const auto [first, last] = robot_lines(lines);
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
          fmt::format(
              "{} = {:.{}f}   {}\n", figure.key, figure.value, kDigits, note_of(figure, from)));
    }
  }
  std::string text;
  for (const std::string& line : lines) text += line;
  static_cast<void>(parse_rig(text, file_name));
  const toml::table top = toml::parse(text);
  for (const AdoptedFigure& figure : figures) {
    const auto value = top["robot"][figure.key].value<double>();
    if (value && *value == rounded_decimal(figure.value, kDigits)) continue;
    throw DataError(
        file_name, Mistake{
                       0, 0, figure.key, "cannot be changed in this file",
                       "write [robot] as a table of its own, one key a line"});
  }
  return text;
}

}  // namespace sixdial::session
