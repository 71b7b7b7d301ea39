// One file of C99: sixdial_forward and sixdial_inverse, with the effects in them.
#include <array>

#include "report/export/source_code.h"
#include "report/export/templates.h"

namespace sixdial::report {
namespace {

constexpr std::array kNames{
    DeclaredName{
        "v",
        "double v[SIXDIAL_PARAMETERS];\n"
        "for (i = 0; i < SIXDIAL_PARAMETERS; ++i) v[i] = sixdial_parameters[i];"},
    DeclaredName{"approach", "const double *const approach = at->approach;"},
    DeclaredName{"travel", "const double *const travel = at->travel;"},
    DeclaredName{"temperature_degC", "const double temperature_degC = at->temperature_degC;"},
    DeclaredName{"time_h", "const double time_h = at->time_h;"},
    DeclaredName{
        "weight", "double weight[SIXDIAL_JOINTS][2];\nsixdial_weight(q_read, weight);"},
    DeclaredName{"stands", "static const double stands[3] = {stands};"},
    DeclaredName{"was", "double was[3];"},
    DeclaredName{"turn", "double turn[3] = {0.0, 0.0, 0.0};"}};

SourceLanguage language() {
  return {
      .model = templates::model_c(),
      .solve = templates::solve_c(),
      .smooth = templates::smooth_c(),
      .parameters = "v, ",
      .keep_place = "for (i = 0; i < 3; ++i) was[i] = p[i];",
      .turn_tool =
          "for (i = 0; i < 3; ++i) {\n"
          "  const double x = turned[i], y = turned[3 + i], z = turned[6 + i];\n"
          "  turned[i] += turn[1] * z - turn[2] * y;\n"
          "  turned[3 + i] += turn[2] * x - turn[0] * z;\n"
          "  turned[6 + i] += turn[0] * y - turn[1] * x;\n"
          "}",
      .names = kNames};
}

HeldModel hold(const studies::ExportedModel& full, const ExportOptions&) {
  return hold_source(full, "a C source");
}

std::string write(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions&) {
  return write_source(full, held, "c", language());
}

}  // namespace

extern constinit const ExportFormat c_format;
constinit const ExportFormat c_format{
    .name = "c",
    .in_words = "a C source",
    .about = "source of C99: forward and inverse kinematics with the causes",
    .file_name = "robot.c",
    .hold = hold,
    .write = write};

}  // namespace sixdial::report
