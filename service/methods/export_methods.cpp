// A robot given to other programs.
#include <fmt/format.h>

#include <array>

#include "report/documents/calibration_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/warnings_document.h"
#include "report/export/exported_json.h"
#include "service/methods/shared_params.h"
#include "service/recommended_model.h"
#include "service/result_lookup.h"
#include "service/text_page.h"
#include "studies/exported_model.h"

namespace sixdial::service {
namespace {

/// By default the calibrated robot; robot and causes where a diagnosis is asked for.
bool exports_extended(const Call& call) {
  const bool asked = call.params.contains("diagnosis");
  return param_or<std::string>(call.params, "by", asked ? "extended" : "kinematics") ==
         "extended";
}

report::ExportOptions export_options(const Call& call) {
  report::ExportOptions options;
  for (const char* const key : {"endstop_a_mm", "endstop_b_mm", "endstop_c_mm"}) {
    if (call.params.contains(key)) {
      options.endstops_mm.push_back(call.params[key].get<double>());
    }
  }
  options.urdf_text = param_or<std::string>(call.params, "urdf_text", "");
  return options;
}

Json export_robot(const Call& call) {
  const bool extended = exports_extended(call);
  const db::ResultRecord record = extended ? extending_record(call) : calibration_record(call);
  const Json document = Json::parse(record.json);
  const auto warnings = warnings_of(call.service.reader(), record, document);
  report::check_may_command(warnings);
  const session::Session session = call.service.reader().load_session(record.session);
  const studies::ExportedModel model =
      extended ? studies::exported_model(report::diagnosis_from_json(document), session)
               : studies::exported_model(report::calibration_from_json(document), session);
  const report::Exported exported = report::export_model(
      model, call.params.at("as").get<std::string>(), export_options(call));
  const auto begin = param_or<std::size_t>(call.params, "offset", 0);
  if (begin > exported.text.size()) {
    throw Error(
        ErrorCode::kInvalidParams,
        fmt::format("offset {} is beyond the {} bytes", begin, exported.text.size()),
        {{"param", "offset"}});
  }
  const std::size_t end = page_end(exported.text, begin);
  Json answer = report::to_json(exported);
  answer["result"] = record.id.value;
  answer["warnings"] = report::warnings_json(warnings);
  answer["bytes"] = exported.text.size();
  answer["text"] = exported.text.substr(begin, end - begin);
  answer["next_offset"] = end < exported.text.size() ? Json(end) : Json(nullptr);
  return answer;
}

constexpr std::array<std::string_view, 2> kExportedWays{"kinematics", "extended"};
constexpr Param endstop(std::string_view name, std::string_view doc) {
  return {.name = name, .type = ParamType::kNumber, .doc = doc, .min = -1e5, .max = 1e5};
}
constexpr std::array kExportParams{
    Param{
        .name = "session", .doc = "its newest calibration is used, unless `result` says which"},
    Param{
        .name = "result",
        .type = ParamType::kInteger,
        .doc = "number of a calibration",
        .min = 1},
    Param{
        .name = "as",
        .required = true,
        .doc = "format of the text: a C99 or Python source, JSON with everything, Klipper's "
               "delta block, lines of LinuxCNC's genserkins, Universal Robots' "
               "default_kinematics.yaml, a URDF: c, python, json, klipper, linuxcnc, ur, urdf"},
    Param{
        .name = "by",
        .doc = "kinematics: the calibrated robot; extended: robot and named causes of a "
               "diagnosis; default: extended where `diagnosis` is given, else kinematics",
        .one_of = kExportedWays},
    Param{
        .name = "diagnosis",
        .type = ParamType::kInteger,
        .doc = "number of a diagnosis, of by extended; default: the newest of the session",
        .min = 1},
    params::kFromOtherSession,
    Param{
        .name = "urdf_text",
        .doc = "of as urdf: the URDF that the arm came from, whose origins are set right; "
               "default: a new one"},
    Param{
        .name = "offset",
        .type = ParamType::kInteger,
        .doc = "the text from this byte on; default 0",
        .min = 0},
    endstop(
        "endstop_a_mm",
        "of as klipper: position_endstop of stepper_a as printer.cfg has it now"),
    endstop("endstop_b_mm", "the same of stepper_b"),
    endstop("endstop_c_mm", "the same of stepper_c")};
constexpr std::array kMethods{
    RpcMethod{
        .name = "model.export",
        .summary =
            "The calibrated robot, alone or with its named causes, as what other programs run: "
            "C, Python, JSON, URDF and others; what is left out is told.",
        .params = kExportParams,
        .result = "format, file_name, model, left_out [{what, why, instead, values, miss "
                  "{mean_mm, max_mm, poses}}], notes, miss (of all that is left out together), "
                  "result, warnings, bytes, text (a page of it), next_offset (null: the last "
                  "page)",
        .example = R"({"session": "demo", "as": "python"})",
        .runs_on = RunsOn::kLong,
        .command = "sixdial export-model {session} --as python",
        .run = export_robot},
};

}  // namespace

std::span<const RpcMethod> export_methods() { return kMethods; }

}  // namespace sixdial::service
