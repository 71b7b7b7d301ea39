// One module of Python 3 with its standard library alone: forward and inverse, with the effects
// in them.
#include <array>

#include "report/export/source_code.h"
#include "report/export/templates.h"

namespace sixdial::report {
namespace {

constexpr std::array kNames{
    DeclaredName{"v", "v = list(PARAMETERS)"},
    DeclaredName{"approach", "approach = moment.approach"},
    DeclaredName{"travel", "travel = moment.travel"},
    DeclaredName{"temperature_degC", "temperature_degC = moment.temperature_degC"},
    DeclaredName{"time_h", "time_h = moment.time_h"},
    DeclaredName{"weight", "weight = moments_of_weight(q_read)"},
    DeclaredName{"stands", "stands = {stands}"},
    DeclaredName{"turn", "turn = [0.0, 0.0, 0.0]"}};

SourceLanguage language() {
  return {
      .is_python = true,
      .open = '(',
      .close = ')',
      .end = "",
      .indent = "    ",
      .mark = "",
      .model = templates::model_py(),
      .solve = templates::solve_py(),
      .smooth = templates::smooth_py(),
      .parameters = "v, ",
      .keep_place = "was = list(p)",
      .turn_tool =
          "R = [[R[i][j] + turn[(i + 1) % 3] * R[(i + 2) % 3][j] - turn[(i + 2) % 3] "
          "* R[(i + 1) % 3][j]\n"
          "      for j in range(3)] for i in range(3)]",
      .names = kNames};
}

HeldModel hold(const studies::ExportedModel& full, const ExportOptions&) {
  return hold_source(full, "a Python source");
}

std::string write(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions&) {
  return write_source(full, held, "python", language());
}

}  // namespace

extern constinit const ExportFormat python_format;
constinit const ExportFormat python_format{
    .name = "python",
    .in_words = "a Python source",
    .about = "the same as a module of Python 3, standard library only",
    .file_name = "robot.py",
    .hold = hold,
    .write = write};

}  // namespace sixdial::report
