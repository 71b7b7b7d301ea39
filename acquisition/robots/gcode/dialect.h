// What a controller that takes G-code says, and what to say to it: a row and a pure parser of
// one line a firmware, one file each in this folder.
//
//   const GcodeDialect& grbl = *find_gcode_dialect("grbl");
//   grbl.parse("<Idle|MPos:10.000,-5.250,0.000|FS:0,0>")->machine[1].value;  // -5.25
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/robot.h"

namespace sixdial::acquisition {

/// Axis letters in the order in which controllers list their axes.
inline constexpr std::string_view kGcodeAxes = "XYZABCUVW";

enum class GcodeLineKind {
  kOk,         // the line before was taken
  kError,      // ... or was not
  kAlarm,      // everything is locked until a person looks
  kReport,     // where it stands
  kRestarted,  // the greeting: it was switched on, or reset
  kRemark,     // anything else that it may say
};

/// As the controller prints it.
struct AxisFigure {
  char letter = 'X';
  double value = 0.0;  // deg or mm
  int decimals = 0;    // digits after the point
};

struct GcodeLine {
  GcodeLineKind kind = GcodeLineKind::kRemark;
  std::string words{};  // of an error or alarm
  /// An error: the target lies beyond the travel, others may not.
  bool unreachable = false;
  // Of a report.
  std::optional<Motion> motion{};      // empty: it does not say
  bool halted = false;                 // by a feed hold, and at rest
  std::vector<AxisFigure> position{};  // in the coordinates of the commands
  std::vector<AxisFigure> machine{};   // ... in those of the machine
  std::vector<AxisFigure> offset{};    // machine less commands
};

struct GcodeDialect {
  std::string_view name;      // dialect=...
  std::string_view in_words;  // "Grbl 1.1 and grblHAL"
  int baud = 115200;          // as it comes from its makers
  std::string_view hello;     // is answered with "ok" and moves nothing
  /// Asks where it stands; answered with a report, and then "ok" where it is a line.
  std::string_view ask;
  bool ask_is_line = false;
  /// A line that is answered with "ok" once all moves have ended.
  std::string_view wait;
  /// Sent while a move is waited for, and answered with a report at once; empty: it cannot.
  std::string_view look{};
  /// Bytes that stop the motion at once.
  std::string_view halt;
  /// Bytes that drop the rest of a halted move, answered with the greeting; empty: `halt` did.
  std::string_view drop{};
  std::string_view how_it_halts;  // for people: what to set, what to do afterwards
  /// One line without its end. Empty: no line of this firmware.
  std::optional<GcodeLine> (*parse)(std::string_view line) = nullptr;
};

[[nodiscard]] std::span<const GcodeDialect* const> gcode_dialects();
/// nullptr if there is none of that name.
[[nodiscard]] const GcodeDialect* find_gcode_dialect(std::string_view name);

/// "12.345", "-0.50", "7": all of `text`, finite and below 1e9. Empty otherwise.
[[nodiscard]] std::optional<AxisFigure> axis_figure(char letter, std::string_view text);
/// "X:1.00 Y:2.00 Z:0.00 E:0.00 Count X:80 Y:160": up to "Count" or the end. Empty if anything
/// in it is no axis, or an axis comes twice.
[[nodiscard]] std::optional<std::vector<AxisFigure>> lettered_axes(std::string_view text);
/// Bytes that text may hold, so that noise on a line is not taken for a remark.
[[nodiscard]] bool is_text(std::string_view line);

}  // namespace sixdial::acquisition
