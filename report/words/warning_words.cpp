#include "report/words/warning_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "report/text.h"
#include "report/words/warning_table.h"
#include "report/words/wrapped.h"
#include "simulation/effect_words.h"

namespace sixdial::report {
namespace {

using studies::Warning;

const WarningWords* words_of(std::string_view code) {
  const auto table = warning_table();
  const auto found = std::ranges::find(table, code, &WarningWords::code);
  return found == table.end() ? nullptr : &*found;
}

std::string plain(double value) {
  return value == std::floor(value) && std::abs(value) < 1e9 ? fmt::format("{:.0f}", value)
                                                             : simulation::in_digits(value, 4);
}

/// By a form of {fmt}; "g" and ".2g" without an exponent.
std::string formed(double value, std::string_view form) {
  if (form == "g") return simulation::in_digits(value, 6);
  if (form.size() == 3 && form[0] == '.' && form[2] == 'g') {
    return simulation::in_digits(value, form[1] - '0');
  }
  return fmt::format(fmt::runtime(fmt::format("{{:{}}}", form)), value);
}

/// A brace's text for "name", "name:form", "name:one|many" or "name|one|many"; false: there is
/// no such part.
bool fill(std::string_view brace, const Warning& warning, std::string& out) {
  const std::size_t end = brace.find_first_of(":|");
  const std::string name(brace.substr(0, end));
  const bool with_number = end == std::string_view::npos || brace[end] == ':';
  const std::string_view form =
      end == std::string_view::npos ? std::string_view() : brace.substr(end + 1);
  std::variant<double, std::string> part = static_cast<double>(warning.where.rows);
  if (name != "rows") {
    const auto found = warning.parts.find(name);
    if (found == warning.parts.end()) return false;
    part = found->second;
  }
  const auto* number = std::get_if<double>(&part);
  if (number == nullptr) {
    out += valid_utf8(std::get<std::string>(part));
  } else if (const std::size_t bar = form.find('|'); bar != std::string_view::npos) {
    if (with_number) out += plain(*number) + " ";
    out += *number == 1.0 ? form.substr(0, bar) : form.substr(bar + 1);
  } else if (!form.empty()) {
    out += formed(*number, form);
  } else {
    out += plain(*number);
  }
  return true;
}

std::string filled(std::string_view text, const Warning& warning) {
  std::string out;
  std::size_t option = std::string::npos;  // where an option in [ ] began
  bool all_there = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '[') {
      option = out.size();
      all_there = true;
    } else if (text[i] == ']') {
      if (!all_there) out.resize(option);
      option = std::string::npos;
    } else if (text[i] == '{') {
      const std::size_t end = text.find('}', i);
      if (!fill(text.substr(i + 1, end - i - 1), warning, out)) all_there = false;
      i = end;
    } else {
      out += text[i];
    }
  }
  return out;
}

/// Line numbers that follow each other as one item: "12 to 19".
std::vector<std::string> line_runs(const std::vector<studies::RowName>& rows) {
  std::vector<std::string> items;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end].line == rows[end - 1].line + 1) ++end;
    constexpr std::size_t kLeastRun = 3;
    if (end - i >= kLeastRun) {
      items.push_back(fmt::format("{} to {}", rows[i].line, rows[end - 1].line));
      i = end;
    } else {
      items.push_back(fmt::format("{}", rows[i++].line));
    }
  }
  return items;
}

/// "3, 5 and 9"; "3, 5, 9 ... (25 in all)".
std::string listed(const std::vector<std::string>& items, bool more, int total) {
  if (items.empty()) return "";
  if (more) return fmt::format("{} ... ({} in all)", fmt::join(items, ", "), total);
  if (items.size() == 1) return items.front();
  return fmt::format(
      "{} and {}", fmt::join(std::span(items).first(items.size() - 1), ", "), items.back());
}

}  // namespace

std::string warning_text(const Warning& warning) {
  const WarningWords* words = words_of(warning.code);
  return words == nullptr ? warning.code : filled(words->text, warning);
}

std::string where_text(const studies::WarningPlace& place) {
  std::string text = place.file;
  const bool lines = std::ranges::all_of(
      place.named, [](const studies::RowName& row) { return row.line > 0; });
  std::vector<std::string> items;
  if (lines) {
    items = line_runs(place.named);
  } else {
    text.clear();  // a sample that was measured here stands in no file
    for (const studies::RowName& row : place.named) {
      items.push_back(
          row.repeat > 0 ? fmt::format("{} point {} repeat {}", row.set, row.point, row.repeat)
                         : fmt::format("{} point {}", row.set, row.point));
    }
  }
  if (!items.empty()) {
    if (!text.empty()) text += ", ";
    if (lines) text += place.rows > 1 ? "lines " : "line ";
    text += listed(items, place.rows > static_cast<int>(place.named.size()), place.rows);
  }
  if (!place.field.empty()) {
    const bool rig = place.file == "rig.toml";
    text +=
        fmt::format("{}{} {}", text.empty() ? "" : ", ", rig ? "key" : "column", place.field);
  }
  return text;
}

std::string warning_line(const Warning& warning) {
  const std::string where = where_text(warning.where);
  return warning_text(warning) + (where.empty() ? "" : " (" + where + ")");
}

std::vector<std::string> warning_lines(const std::vector<Warning>& warnings) {
  std::vector<std::string> lines;
  for (const Warning& each : warnings) lines.push_back(warning_line(each));
  return lines;
}

std::string warnings_text(const std::vector<Warning>& warnings) {
  std::string text;
  for (const std::string& line : warning_lines(warnings)) text += wrapped("! " + line, "  ");
  return text;
}

std::string_view severity_name(studies::Severity severity) {
  switch (severity) {
    case studies::Severity::kNote:
      return "note";
    case studies::Severity::kDoubt:
      return "doubt";
    case studies::Severity::kWrong:
      return "wrong";
  }
  return "wrong";
}

bool has_words(std::string_view code) { return words_of(code) != nullptr; }

}  // namespace sixdial::report
