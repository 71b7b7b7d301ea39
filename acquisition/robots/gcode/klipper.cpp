// Klipper on its pseudo-terminal (printer_data/comms/klippy.serial): "ok", "!! Move out of
// range: ...", "// a remark", and to M114 "X:10.000 Y:-5.250 Z:0.000 E:0.000", then "ok".
#include "acquisition/robots/gcode/dialect.h"

namespace sixdial::acquisition {
namespace {

std::optional<GcodeLine> parse(std::string_view line) {
  if (!is_text(line)) return std::nullopt;
  if (line == "ok" || line.starts_with("ok ")) return GcodeLine{.kind = GcodeLineKind::kOk};
  if (line.starts_with("!!")) {
    return GcodeLine{
        .kind = GcodeLineKind::kError,
        .words = std::string(line),
        .unreachable = line.find("out of range") != std::string_view::npos};
  }
  if (line.starts_with("X:")) {
    auto axes = lettered_axes(line);
    if (!axes) return std::nullopt;
    return GcodeLine{.kind = GcodeLineKind::kReport, .position = *std::move(axes)};
  }
  if (!line.empty() && !line.starts_with("//") && !line.starts_with("echo:") &&
      !line.starts_with("B:") && !line.starts_with("T0:")) {
    return std::nullopt;
  }
  return GcodeLine{.kind = GcodeLineKind::kRemark};
}

}  // namespace

extern constinit const GcodeDialect klipper{
    .name = "klipper",
    .in_words = "Klipper, by its pseudo-terminal (printer_data/comms/klippy.serial)",
    .baud = 250000,
    .hello = "M400",
    .ask = "M114",
    .ask_is_line = true,
    .wait = "M400",
    .halt = "M112\n",
    .how_it_halts = "by M112, its emergency stop: FIRMWARE_RESTART and homing come next",
    .parse = parse};

}  // namespace sixdial::acquisition
