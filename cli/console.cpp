#include "cli/console.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "cli/printable.h"
#include "service/socket/request.h"

namespace sixdial::cli {
namespace {

constexpr int kSchemaVersion = 1;
constexpr std::size_t kBarCells = 24;
constexpr std::size_t kLeastCells = 6;
constexpr std::size_t kLeastBar = kLeastCells + 3;

/// Columns of a UTF-8 text on a terminal, for the letters used here.
std::size_t shown_width(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

bool looks_like_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.+-e ") == std::string::npos;
}

}  // namespace

void Console::print_json(std::string_view schema, const Json& document) const {
  Json whole = document;
  const std::string name = fmt::format("sixdial.{}", schema);
  // A document that is one of this schema already knows its version.
  if (whole.value("schema", std::string()) != name || !whole.contains("schema_version")) {
    whole["schema"] = name;
    whole["schema_version"] = kSchemaVersion;
  }
  out << json_for_terminal(service::to_line(whole)) << '\n';
}

void Console::print(
    std::string_view schema, const Json& document, const std::string& text) const {
  if (json) {
    print_json(schema, document);
  } else {
    out << for_terminal(text);
  }
}

void Console::print_data(std::string_view text) const {
  out << (out_terminal ? for_terminal(text) : std::string(text));
}

void Console::send(std::string_view text) const {
  if (text.empty()) return;
  // std::cerr writes at each <<, so pieces would be seen one by one.
  err.write(text.data(), static_cast<std::streamsize>(text.size()));
  err.flush();
}

void Console::note(const std::string& text) const { send(for_terminal(text) + '\n'); }

void Console::warn(const std::string& text) const {
  send((colour ? "\x1b[33mwarning:\x1b[0m " : "warning: ") + for_terminal(text) + '\n');
}

void Console::error(const Json& error_object) const {
  std::string text = error_object.value("message", std::string("without words")) + '\n';
  const Json data = error_object.value("data", Json::object());
  const Json at = data.value("at", Json::object());
  for (const auto& [key, value] : at.items()) {
    if (key == "findings" || key == "missing") continue;
    text += fmt::format(
        "  {}: {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
  const std::string hint = data.value("hint", std::string());
  // Some say in the message what to do, and once is enough.
  const bool said =
      error_object.value("message", std::string()).find(hint) != std::string::npos;
  if (!hint.empty() && !said) text += fmt::format("  {}\n", hint);
  send((colour ? "\x1b[31merror:\x1b[0m " : "error: ") + for_terminal(text));
  if (json) print_json("error", {{"error", error_object}});
}

std::string text_table(
    const std::vector<std::string>& titles, const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  std::vector<bool> numeric;
  for (std::size_t column = 0; column < titles.size(); ++column) {
    std::size_t width = shown_width(titles[column]);
    bool numbers = !rows.empty();
    for (const auto& row : rows) {
      width = std::max(width, shown_width(row[column]));
      numbers = numbers && (looks_like_number(row[column]) || row[column] == "-");
    }
    widths.push_back(width);
    numeric.push_back(numbers);
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    std::string line;
    for (std::size_t column = 0; column < titles.size(); ++column) {
      if (column > 0) line += "  ";
      const std::string padding(widths[column] - shown_width(row[column]), ' ');
      line += numeric[column] ? padding + row[column] : row[column] + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add(titles);
  for (const auto& row : rows) add(row);
  return text;
}

std::string duration_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::ceil(std::max(seconds, 0.0)));
  return whole >= 3600
             ? fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
             : fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::size_t terminal_width() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? size.ws_col - 1U : 79U;
}

std::size_t terminal_height() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0;
  return known ? size.ws_row : 24U;
}

std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  const std::string indent = width > 20 ? "    " : "";
  std::vector<std::string> lines;
  std::string rest = text;
  while (rest.size() > width) {
    std::size_t end = rest.rfind(' ', width);
    if (end == std::string::npos || rest.find_first_not_of(' ') >= end) end = width;
    lines.push_back(rest.substr(0, end));
    const std::size_t next = rest.find_first_not_of(' ', end);
    rest = next == std::string::npos ? "" : indent + rest.substr(next);
    if (rest.empty()) return lines;
  }
  lines.push_back(rest);
  return lines;
}

std::size_t rows_of(std::size_t letters, std::size_t width) {
  return letters == 0 ? 1 : (letters + width - 1) / width;
}

std::string progress_text(
    double fraction, const std::string& text, std::size_t width, std::string_view remark) {
  const std::string whole = remark.empty() ? text : fmt::format("{}  {}", text, remark);
  const std::string& said = whole.size() + kLeastBar <= width ? whole : text;
  const std::size_t room = width > said.size() + 3 ? width - said.size() - 3 : 0;
  const std::size_t cells = std::min<std::size_t>(room, kBarCells);
  if (cells < kLeastCells) return said.substr(0, width);
  const auto full = static_cast<std::size_t>(fraction * static_cast<double>(cells));
  return fmt::format("[{}{}] {}", std::string(full, '#'), std::string(cells - full, '.'), said);
}

std::string ProgressLine::drawn(
    std::string_view stage, std::int64_t done, std::int64_t total, std::optional<double> eta_s,
    std::string_view remark) {
  if (console_.quiet) return "";
  const double fraction =
      total > 0 ? std::clamp(static_cast<double>(done) / static_cast<double>(total), 0.0, 1.0)
                : 0.0;
  std::string text = fmt::format("{} {}/{}", for_terminal(stage), done, total);
  constexpr double kNotWorthSaying_s = 1.0;
  if (eta_s && *eta_s >= kNotWorthSaying_s)
    text += fmt::format("  {} left", duration_text(*eta_s));
  if (console_.terminal) {
    const std::string before = erased();
    const std::string line = progress_text(fraction, text, terminal_width(), remark);
    on_screen_ = line.size();
    return before + line;
  }
  if (!remark.empty()) text += fmt::format("  {}", remark);
  const auto tenth = static_cast<std::int64_t>(fraction * 10.0);
  if (stage == shown_stage_ && tenth == shown_tenth_) return "";
  shown_stage_ = stage;
  shown_tenth_ = tenth;
  return text + '\n';
}

std::string ProgressLine::erased() {
  if (on_screen_ == 0) return "";
  // A terminal that was made narrower has wrapped it.
  const std::size_t rows = rows_of(on_screen_, terminal_width() + 1);
  on_screen_ = 0;
  return (rows > 1 ? fmt::format("\x1b[{}A", rows - 1) : std::string()) + "\r\x1b[J";
}

void ProgressLine::show(
    std::string_view stage, std::int64_t done, std::int64_t total, std::optional<double> eta_s,
    std::string_view remark) {
  console_.send(drawn(stage, done, total, eta_s, remark));
}

void ProgressLine::show(const studies::Progress& progress) {
  show(
      progress.stage, progress.done, progress.total, progress.eta_s,
      progress.best_mm ? fmt::format("best {:.6f} mm", *progress.best_mm) : std::string());
}

void ProgressLine::clear() { console_.send(erased()); }

}  // namespace sixdial::cli
