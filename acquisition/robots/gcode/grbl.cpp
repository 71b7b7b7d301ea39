// Grbl 1.1 and grblHAL: "ok", "error:9", "ALARM:2", "[MSG:...]", "$100=250.0", "Grbl 1.1h ['$'
// for help]", and the report that '?' asks for at any time,
//   <Idle|MPos:10.000,-5.250,0.000|FS:0,0|WCO:5.000,0.000,0.000>
// whose coordinates are the machine's (MPos) or those of the commands (WPos = MPos - WCO).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "acquisition/robots/gcode/dialect.h"

namespace sixdial::acquisition {
namespace {

// By the interface page of its wiki; those that a move can meet.
constexpr std::array kErrors{
    std::pair{2, "a number is missing or misspelt"},
    std::pair{8, "it does not stand still"},
    std::pair{
        9, "it is locked by an alarm: look at the machine, then unlock it with $X or home it"},
    std::pair{11, "the line is too long"},
    std::pair{15, "the target lies beyond its travel"},
    std::pair{20, "it does not know this command"},
    std::pair{22, "no feed rate"},
    std::pair{33, "the target is not allowed"}};
constexpr std::array kAlarms{
    std::pair{1, "a limit switch was hit: its position is lost, home it"},
    std::pair{2, "the target lies beyond its travel ($130, $131, ...): unlock it with $X"},
    std::pair{3, "it was reset while it moved: its position is lost, home it"},
    std::pair{6, "homing was reset"},
    std::pair{8, "homing did not leave the limit switch"},
    std::pair{9, "homing did not find the limit switch"}};

template <std::size_t count>
std::string in_words(
    std::string_view what, int code,
    const std::array<std::pair<int, const char*>, count>& all) {
  for (const auto& [number, words] : all) {
    if (number == code) return fmt::format("{}:{}, {}", what, code, words);
  }
  return fmt::format("{}:{}, which its manual explains", what, code);
}

std::optional<int> code_after(std::string_view line, std::string_view head) {
  if (!line.starts_with(head)) return std::nullopt;
  line.remove_prefix(head.size());
  int code = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), code);
  if (error != std::errc{} || end != line.data() + line.size() || code < 0) return std::nullopt;
  return code;
}

/// "10.000,-5.250,0.000": in the order of the letters.
bool listed_axes(std::string_view text, std::vector<AxisFigure>& axes) {
  if (!axes.empty()) return false;
  while (axes.size() < kGcodeAxes.size()) {
    const std::size_t comma = text.find(',');
    const auto figure = axis_figure(kGcodeAxes[axes.size()], text.substr(0, comma));
    if (!figure) return false;
    axes.push_back(*figure);
    if (comma == std::string_view::npos) return true;
    text.remove_prefix(comma + 1);
  }
  return false;
}

bool take_state(std::string_view state, GcodeLine& line) {
  const std::string_view name = state.substr(0, state.find(':'));
  if (name == "Idle") {
    line.motion = Motion::kInPosition;
  } else if (name == "Run" || name == "Jog" || name == "Home") {
    line.motion = Motion::kMoving;
  } else if (name == "Hold" || name == "Door") {
    // 0: it stands. Others: it slows down, or begins again.
    line.motion = state.ends_with(":0") ? Motion::kFault : Motion::kMoving;
    line.halted = state.ends_with(":0");
    line.words = name == "Hold" ? "it is held" : "its safety door is open";
  } else if (name == "Alarm" || name == "Check" || name == "Sleep" || name == "Tool") {
    line.motion = Motion::kFault;
    line.words =
        name == "Alarm"
            ? "it is locked by an alarm: look at the machine, then unlock it with $X or home it"
            : fmt::format("it is in its mode {}", name);
  } else {
    return false;
  }
  return true;
}

std::optional<GcodeLine> report(std::string_view line) {
  line = line.substr(1, line.size() - 2);
  GcodeLine result{.kind = GcodeLineKind::kReport};
  bool first = true;
  while (true) {
    const std::size_t bar = line.find('|');
    const std::string_view field = line.substr(0, bar);
    bool good = true;
    if (first) {
      good = take_state(field, result);
    } else if (field.starts_with("MPos:")) {
      good = listed_axes(field.substr(5), result.machine);
    } else if (field.starts_with("WPos:")) {
      good = listed_axes(field.substr(5), result.position);
    } else if (field.starts_with("WCO:")) {
      good = listed_axes(field.substr(4), result.offset);
    }
    if (!good) return std::nullopt;
    first = false;
    if (bar == std::string_view::npos) break;
    line.remove_prefix(bar + 1);
  }
  if (result.machine.empty() == result.position.empty()) return std::nullopt;
  return result;
}

std::optional<GcodeLine> parse(std::string_view line) {
  if (!is_text(line)) return std::nullopt;
  if (line == "ok") return GcodeLine{.kind = GcodeLineKind::kOk};
  if (const auto code = code_after(line, "error:")) {
    return GcodeLine{
        .kind = GcodeLineKind::kError,
        .words = in_words("error", *code, kErrors),
        .unreachable = *code == 15};
  }
  if (const auto code = code_after(line, "ALARM:")) {
    return GcodeLine{.kind = GcodeLineKind::kAlarm, .words = in_words("ALARM", *code, kAlarms)};
  }
  if (line.starts_with('<') && line.ends_with('>') && line.size() > 2) return report(line);
  if (line.starts_with("Grbl ") || line.starts_with("GrblHAL ")) {
    return GcodeLine{.kind = GcodeLineKind::kRestarted};
  }
  const bool remark = line.empty() || (line.starts_with('[') && line.ends_with(']')) ||
                      line.starts_with('$') || line.starts_with('>');
  if (!remark) return std::nullopt;
  return GcodeLine{.kind = GcodeLineKind::kRemark};
}

}  // namespace

extern constinit const GcodeDialect grbl{
    .name = "grbl",
    .in_words = "Grbl 1.1, grblHAL, FluidNC",
    .baud = 115200,
    .hello = "",
    .ask = "?",
    .wait = "G4 P0.01",
    .look = "?",
    .halt = "!",
    .drop = "\x18",
    .how_it_halts = "by a feed hold; the rest of the move is dropped before the next one",
    .parse = parse};

}  // namespace sixdial::acquisition
