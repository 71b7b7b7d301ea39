// Any bytes as what a robot's controller or command says: no crash, and what is read is finite.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "acquisition/robots/exec_command.h"
#include "acquisition/robots/gcode/dialect.h"

using namespace sixdial::acquisition;

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
