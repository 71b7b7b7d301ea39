#include "cli/collect_screen.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "cli/printable.h"
#include "geometry/units.h"
#include "report/documents/estimate_json.h"
#include "report/words/estimate_words.h"

namespace sixdial::cli {
namespace {

constexpr std::size_t kDialsInRow = 3;
constexpr std::size_t kDigitWidth = 3;
constexpr std::size_t kLargeWidth = 26;  // of a dial in large digits
constexpr std::size_t kPlainWidth = 25;  // of a dial in one line

/// Rows of the digits 0..9, three letters each.
constexpr std::array<std::string_view, 3> kDigits{
    " _     _  _     _  _  _  _  _ ", "| |  | _| _||_||_ |_   ||_||_|",
    "|_|  ||_  _|  | _||_|  ||_| _|"};

std::string large_row(std::string_view text, std::size_t row) {
  std::string line;
  for (const char letter : text) {
    if (letter >= '0' && letter <= '9') {
      line += kDigits.at(row).substr(
          static_cast<std::size_t>(letter - '0') * kDigitWidth, kDigitWidth);
    } else if (letter == '.') {
      line += row == 2 ? "." : " ";
    } else if (letter == '-') {
      line += row == 1 ? " _ " : "   ";
    } else {
      line += "   ";
    }
    line += ' ';
  }
  return line;
}

std::string value_text(const Json& dial) {
  return dial["value_mm"].is_number() ? fmt::format("{:6.3f}", dial["value_mm"].get<double>())
                                      : std::string("--.---");
}

std::string state_text(const Json& dial) {
  const auto state = dial.value("state", "");
  if (state == "free") return "no contact";
  if (state == "waiting") return "moving";
  if (state == "lost") return "LOST: " + dial.value("words", dial.value("reason", ""));
  return state == "stale" ? "STALE" : state;
}

std::string caption(const std::string& id, const Json& dial) {
  if (!dial["value_mm"].is_number()) return fmt::format("{} {}", id, state_text(dial));
  return fmt::format("{} {:.3f} mm  {}", id, dial["value_mm"].get<double>(), state_text(dial));
}

/// What a person has to know at once: a silent controller, and what lost dials say.
std::vector<std::string> warnings_of(const Json& live) {
  constexpr double kSilent_s = 0.5;
  std::vector<std::string> lines;
  const double silent_s = live.value("robot_silent_s", 0.0);
  if (silent_s >= kSilent_s) {
    lines.push_back(fmt::format(
        "THE ROBOT'S CONTROLLER HAS NOT ANSWERED FOR {:.0f} s: the robot may be moving. "
        "Emergency stop if in doubt.",
        std::max(1.0, silent_s)));
  }
  for (const auto& [id, dial] : live["dials"].items()) {
    if (dial.value("state", "") != "lost" || !dial.contains("detail")) continue;
    lines.push_back(fmt::format("{}: {}", id, dial["detail"].get<std::string>()));
  }
  return lines;
}

std::string pose_line(const Json& live) {
  if (live.value("stage", "") == "watching")
    return "nothing is collected: readings as they are";
  const Json& pose = live["pose"];
  std::string text = pose.is_object()
                         ? fmt::format(
                               "tool x {:.3f}  y {:.3f} mm  gamma {:.3f} deg",
                               pose["x_mm"].get<double>(), pose["y_mm"].get<double>(),
                               geometry::kDegPerRad * pose["gamma_rad"].get<double>())
                         : std::string("tool: no position, as fewer than three dials tell");
  const Json& settle = live["settle"];
  if (settle["spread_mm"].is_number()) {
    text += fmt::format(
        "   {}: {:.3f} of {:.3f} mm", settle["settled"] == true ? "settled" : "settling",
        settle["spread_mm"].get<double>(), settle["limit_mm"].get<double>());
  }
  return text;
}

std::string point_text(const Json& state) {
  const Json& point = state["point"];
  if (!point.is_object()) return "";
  return fmt::format(
      "{} {}.{} ", point["set"].get<std::string>(), point["point"].get<int>(),
      point["repeat"].get<int>());
}

}  // namespace

std::string sample_line(const Json& sample) {
  std::string text = fmt::format(
      "{} {}.{}", sample["set"].get<std::string>(), sample["point"].get<int>(),
      sample["repeat"].get<int>());
  const Json& position = sample["position_mm"];
  text += position.is_array() ? fmt::format(
                                    "  x {:.3f}  y {:.3f} mm ", position[0].get<double>(),
                                    position[1].get<double>())
                              : std::string("  no position ");
  for (const auto& [id, dial] : sample["dials"].items()) {
    text += dial["value_mm"].is_number()
                ? fmt::format(" {} {:.3f}", id, dial["value_mm"].get<double>())
                : fmt::format(" {} -", id);
  }
  for (const Json& remark : sample["remarks"]) text += "; " + remark.get<std::string>();
  if (sample["remarks"].empty() && !sample.value("doubt", std::string()).empty()) {
    text += "; " + sample["doubt"].get<std::string>() + ": r measures it again";
  }
  return text;
}

std::vector<std::string> dial_lines(const Json& live, std::size_t width) {
  std::vector<std::string> lines;
  const bool large = width >= kDialsInRow * kLargeWidth;
  const std::size_t cell = large ? kLargeWidth : kPlainWidth;
  std::vector<std::string> rows(large ? 4 : 1);
  const std::size_t most = std::clamp<std::size_t>(width / cell, 1, kDialsInRow);
  std::size_t in_row = 0;
  const auto flush = [&] {
    for (std::string& row : rows) {
      if (in_row > 0) lines.push_back(row.substr(0, width));
      row.clear();
    }
    in_row = 0;
  };
  for (const auto& [id, dial] : live["dials"].items()) {
    if (large) {
      for (std::size_t row = 0; row < 3; ++row) {
        rows[row] += fmt::format("{:<{}}", "  " + large_row(value_text(dial), row), cell);
      }
      rows[3] += fmt::format("{0:<{1}.{2}}", caption(id, dial), cell, cell - 1);
    } else {
      rows[0] += fmt::format(
          "{0:<{1}.{2}}", fmt::format("{} {} {}", id, value_text(dial), state_text(dial)), cell,
          cell - 1);
    }
    if (++in_row == most) flush();
  }
  flush();
  for (const std::string& each : wrapped(pose_line(live), width)) lines.push_back(each);
  for (const std::string& told : warnings_of(live)) {
    for (const std::string& each : wrapped(told, width)) lines.push_back(each);
  }
  return lines;
}

std::vector<std::string> screen_topics(const Console& console) {
  std::vector<std::string> topics{"collect", "sample"};
  if (console.terminal && !console.json && !console.quiet) topics.emplace_back("live");
  return topics;
}

std::string ScreenBlock::drawn() {
  if (!console_.terminal || !on_screen_.empty() || lines_.empty()) return "";
  // A line that the terminal would wrap could not be taken away again.
  const std::size_t width = terminal_width();
  std::string bytes;
  for (const std::string& line : lines_) {
    const std::string shown = for_terminal(line).substr(0, width);
    bytes += shown + '\n';
    on_screen_.push_back(shown.size());
  }
  return bytes;
}

std::string ScreenBlock::erased() {
  if (on_screen_.empty()) return "";
  std::size_t rows = 0;
  for (const std::size_t letters : on_screen_) rows += rows_of(letters, terminal_width() + 1);
  on_screen_.clear();
  return fmt::format("\r\x1b[{}A\x1b[J", rows);
}

void Screen::show_state(const Json& state) {
  state_ = state;
  const std::string type = state.value("type", "");
  const std::string message = state.value("message", "");
  if (!message.empty() && (type == "paused" || type == "failed" || type == "skipped")) {
    note(fmt::format("{}{}: {}", point_text(state), type, message));
  }
  if (type == "clock_step") note("warning: " + message);
  if (type == "skipped" && state["point"].is_object()) map_.mark(state["point"], "left");
  if (type == "move" && state["move"].is_object()) {
    note(fmt::format(
        "{}{} Then: m, or sixdial collection moved (--at tells where it really stands)",
        point_text(state), state["move"]["words"].get<std::string>()));
  }
  if (type == "estimate" && state["estimate"].is_object() && !console_.json) {
    estimate_ = report::estimate_from_json(state["estimate"]);
    if (console_.terminal && !console_.quiet) return show_block();
  }
  redraw();
}

void Screen::send(const std::string& bytes) const {
  if (bytes.empty()) return;
  console_.send(console_.terminal ? "\x1b[?2026h" + bytes + "\x1b[?2026l" : bytes);
}

std::string Screen::erased() {
  const std::string line = line_.erased();  // first: the block stands above it
  return line + block_.erased();
}

std::string Screen::drawn() {
  const std::string bytes = block_.drawn();
  if (!state_.is_object()) return bytes;
  std::string remark;
  if (console_.terminal) {
    remark = for_terminal(point_text(state_) + state_.value("stage", ""));
  } else if (estimate_) {
    remark = report::estimate_summary(*estimate_);
  }
  return bytes + line_.drawn(
                     "collecting", state_["done"].get<std::int64_t>(),
                     state_["total"].get<std::int64_t>(),
                     state_["eta_s"].is_number() ? std::optional(state_["eta_s"].get<double>())
                                                 : std::nullopt,
                     remark);
}

void Screen::redraw() {
  const std::string line = line_.erased();  // the block above it may stay
  send(line + drawn());
}

void Screen::show_sample(const Json& sample) {
  if (console_.json || console_.quiet) return;
  map_.take_sample(sample);
  // A file or a pipe gets a line at each tenth of the way, and what someone should look at.
  const bool remarkable = !sample["remarks"].empty() || sample.value("doubt", "") != "";
  if (console_.terminal || remarkable) note(sample_line(sample));
}

std::vector<std::string> Screen::lines(std::size_t width, std::size_t height) const {
  constexpr std::size_t kOthers = 3;  // the progress line, and room for a sample
  constexpr std::size_t kGap = 2, kMapRows = 9, kLeastMap = 26, kMostMap = 42;
  constexpr std::size_t kParameterWidth = 28;
  const std::size_t dials_width = kDialsInRow * kLargeWidth;
  const Json next = state_.is_object() ? state_.value("point", Json()) : Json();
  std::vector<std::string> all;
  bool map_beside = false;
  if (live_.is_object()) {
    all = dial_lines(live_, width);
    const std::size_t free = width > dials_width + kGap ? width - dials_width - kGap : 0;
    if (free >= kLeastMap) {
      const auto map = map_.lines(std::min(free, kMostMap), kMapRows, next);
      map_beside = !map.empty();
      // Not beside the line of the pose, which is the last and may be long.
      for (std::size_t i = 0; i < map.size(); ++i) {
        if (i + 1 >= all.size()) all.insert(all.end() - 1, "");
        all[i] = fmt::format("{:<{}}{}", all[i], dials_width + kGap, map[i]);
      }
    }
  }
  std::vector<std::string> keys;
  if (::isatty(STDIN_FILENO) != 0) keys = wrapped(kKeyHelp, width);
  const auto fits = [&](std::size_t more) {
    return all.size() + more + keys.size() + kOthers <= height;
  };
  if (estimate_) {
    const auto summary = wrapped(report::estimate_summary(*estimate_), width);
    const auto parameters = report::estimate_parameters(
        *estimate_, std::clamp<std::size_t>(width / kParameterWidth, 1, 3));
    if (fits(parameters.size() + summary.size())) {
      for (const std::string& each : parameters) all.push_back(each.substr(0, width));
    }
    if (fits(summary.size())) all.insert(all.end(), summary.begin(), summary.end());
  }
  if (!map_beside && fits(kMapRows)) {
    const auto map = map_.lines(std::min(width, kMostMap), kMapRows, next);
    all.insert(all.end(), map.begin(), map.end());
  }
  all.insert(all.end(), keys.begin(), keys.end());
  // What is higher than the terminal could not be taken away again.
  if (height > kOthers && all.size() > height - kOthers) all.resize(height - kOthers);
  return all;
}

void Screen::show_dials(const Json& live) {
  if (!console_.terminal || console_.json || console_.quiet) return;
  live_ = live;
  show_block();
}

void Screen::show_block() {
  const std::string before = erased();
  block_.set(lines(terminal_width(), terminal_height()));
  send(before + drawn());
}

void Screen::note(const std::string& text) {
  if (!console_.terminal) return console_.note(text);
  std::string bytes = erased();
  for (const std::string& each : wrapped(for_terminal(text), terminal_width())) {
    bytes += each + '\n';
  }
  send(bytes + drawn());
}

void Screen::end() { send(erased()); }

}  // namespace sixdial::cli
