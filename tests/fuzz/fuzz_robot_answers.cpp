// Any bytes as what a robot's controller or command says: no crash, and what is read is finite.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "acquisition/robots/exec_command.h"
#include "acquisition/robots/gcode/dialect.h"
#include "acquisition/robots/klipper/message.h"
#include "acquisition/robots/linuxcnc/lines.h"

using namespace sixdial::acquisition;

namespace {

void look_at(const std::vector<double>& figures) {
  for (const double each : figures) {
    if (!std::isfinite(each)) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static const std::vector<RobotJoint> joints{{"theta1", true}, {"slide", false}};
  for (const GcodeDialect* dialect : gcode_dialects()) {
    const auto line = dialect->parse(text);
    if (!line) continue;
    for (const auto* axes : {&line->position, &line->machine, &line->offset}) {
      for (const AxisFigure& each : *axes) {
        if (!std::isfinite(each.value) || each.decimals < 0) std::abort();
      }
    }
  }
  if (const auto message = parse_klipper(text)) {
    if (!std::isfinite(message->status.velocity)) std::abort();
    for (const auto* figures :
         {&message->status.live, &message->status.planned, &message->status.commanded,
          &message->status.low, &message->status.high}) {
      look_at(*figures);
      if (!figures->empty() && figures->size() < kKlipperAxes.size()) std::abort();
    }
  }
  if (const auto line = parse_linuxcnc(text); line && line->kind == CncLineKind::kValue) {
    if (const auto figures = cnc_figures(line->rest)) look_at(*figures);
  }
  const auto answer = parse_exec_output(text, joints);
  if (!answer && answer.error().empty()) std::abort();
  if (answer && answer->q && (answer->q->size() != 2 || !answer->q->allFinite())) std::abort();
  const auto words = exec_words(text, joints);
  if (!words && words.error().empty()) std::abort();
  if (words &&
      filled_in(*words, joints, Eigen::Vector2d(0.5, 10), 50).size() != words->size()) {
    std::abort();
  }
  return 0;
}
