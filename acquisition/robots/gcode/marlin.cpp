// Marlin 2: "ok", "ok P15 B3",
// "Error:Printer halted. kill() called!", "echo:busy: processing", "start", and to M114
//   X:10.00 Y:-5.25 Z:0.00 E:0.00 Count X:800 Y:-420 Z:0
// followed by "ok". It says much else, which is passed over if it is text.
#include "acquisition/robots/gcode/dialect.h"

namespace sixdial::acquisition {
namespace {

std::optional<GcodeLine> parse(std::string_view line) {
  if (!is_text(line)) return std::nullopt;
  if (line == "ok" || line.starts_with("ok ")) return GcodeLine{.kind = GcodeLineKind::kOk};
  if (line.starts_with("Error:") || line.starts_with("!!")) {
    return GcodeLine{.kind = GcodeLineKind::kError, .words = std::string(line)};
  }
  if (line.starts_with("Resend:") || line.starts_with("rs ")) {
    return GcodeLine{
        .kind = GcodeLineKind::kError, .words = "it asks for a line again: look at the cable"};
  }
  if (line == "start" || line.starts_with("Marlin ")) {
    return GcodeLine{.kind = GcodeLineKind::kRestarted};
  }
  if (line.starts_with("X:")) {
    auto axes = lettered_axes(line);
    if (!axes) return std::nullopt;
    return GcodeLine{.kind = GcodeLineKind::kReport, .position = *std::move(axes)};
  }
  return GcodeLine{.kind = GcodeLineKind::kRemark};
}

}  // namespace

extern constinit const GcodeDialect marlin{
    .name = "marlin",
    .in_words = "Marlin 2",
    .baud = 115200,
    .hello = "M400",
    .ask = "M114",
    .ask_is_line = true,
    .wait = "M400",
    .halt = "M410\n",
    .how_it_halts = "by M410, at once only with EMERGENCY_PARSER in its configuration",
    .parse = parse};

}  // namespace sixdial::acquisition
