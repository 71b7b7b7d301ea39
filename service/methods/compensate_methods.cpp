// A calibration put to use: angles for a target or a plan, and validation on the robot.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "report/documents/calibration_json.h"
#include "report/documents/compensation_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/validation_json.h"
#include "report/documents/outside_json.h"
#include "report/documents/warnings_document.h"
#include "service/document_job.h"
#include "service/methods/shared_params.h"
#include "service/patient_files.h"
#include "service/result_lookup.h"
#include "service/session_name.h"
#include "service/store_json.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "studies/extended_command.h"

namespace sixdial::service {
namespace {

studies::CompensateBy by_of(const Json& params) {
  return *studies::compensate_by_from(param_or<std::string>(params, "by", "full"));
}

/// The diagnosis that `diagnosis` names, else the newest of the session.
db::ResultRecord extending_record(const Call& call) {
  Json params = Json::object();
  if (call.params.contains("diagnosis")) params["result"] = call.params["diagnosis"];
  for (const char* key : {"session", "from_other_session"}) {
    if (call.params.contains(key)) params[key] = call.params[key];
  }
  const db::ResultRecord record =
      diagnosis_record({call.service, params, call.caller, call.sink});
  if (record.kind == "diagnosis") return record;
  throw Error(
      ErrorCode::kBadData,
      fmt::format("result {} is a {}, not a diagnosis", record.id.value, record.kind),
      {{"param", "diagnosis"}});
}

Json target(const Call& call) {
  const studies::CompensateBy by = by_of(call.params);
  const bool extended = by == studies::CompensateBy::kExtended;
  const db::ResultRecord record = extended ? extending_record(call) : calibration_record(call);
  const Json document = Json::parse(record.json);
  const auto warnings = report::warnings_in(document);
  report::check_may_command(warnings);
  geometry::Rig rig = call.service.reader().load_rig(record.session);
  rig.robot.working_mode = studies::working_mode_in_use(warnings, rig);
  const auto mode = geometry::working_mode_from(
      param_or<std::string>(call.params, "mode", geometry::to_string(rig.robot.working_mode)));
  const Eigen::Vector2d target_mm(
      call.params.at("x_mm").get<double>(), call.params.at("y_mm").get<double>());
  Json answer;
  if (extended) {
    studies::CommandMoment moment;
    moment.approach = {
        param_or(call.params, "approach1", 0), param_or(call.params, "approach2", 0)};
    if (call.params.contains("temperature_c")) {
      moment.temperature_c = call.params["temperature_c"].get<double>();
    }
    const studies::ExtendedCommand command(
        report::diagnosis_from_json(document).extended_fit, rig);
    answer = report::to_json(studies::commanded_target(
        command.solve(target_mm, *mode, moment), by, target_mm, *mode));
  } else {
    const auto calibrated = report::calibration_from_json(document);
    answer = report::to_json(studies::compensated_target(
        studies::compensation_model(calibrated, rig, by), by, target_mm, *mode));
  }
  answer["result"] = record.id.value;
  answer["warnings"] = report::warnings_json(warnings);
  const studies::MeasuredArea area(call.service.reader().load_session(record.session));
  answer["outside_measured"] =
      report::outside_json(studies::outside_measured(area, target_mm, *mode), 1);
  return answer;
}

Json plan(const Call& call) {
  const studies::CompensateBy by = by_of(call.params);
  const bool extended = by == studies::CompensateBy::kExtended;
  const db::ResultRecord record = extended ? extending_record(call) : calibration_record(call);
  const Json document = Json::parse(record.json);
  const auto warnings = report::warnings_in(document);
  report::check_may_command(warnings);
  geometry::Rig rig = call.service.reader().load_rig(record.session);
  rig.robot.working_mode = studies::working_mode_in_use(warnings, rig);
  const session::Plan asked =
      session::parse_plan(call.params.at("plan_csv").get<std::string>(), "plan", rig);
  std::optional<double> temperature_c;
  if (call.params.contains("temperature_c")) {
    temperature_c = call.params["temperature_c"].get<double>();
  }
  const session::Plan compensated =
      extended
          ? studies::extended_plan(
                asked,
                studies::ExtendedCommand(
                    report::diagnosis_from_json(document).extended_fit, rig),
                rig, "", temperature_c)
          : studies::compensated_plan(
                asked,
                studies::compensation_model(report::calibration_from_json(document), rig, by),
                rig);
  const studies::MeasuredArea area(call.service.reader().load_session(record.session));
  Json answer{
      {"result", record.id.value},
      {"points", compensated.points.size()},
      {"warnings", report::warnings_json(warnings)},
      {"outside_measured",
       report::outside_json(
           studies::outside_measured(area, asked, rig), asked.points.size())}};
  if (!call.params.contains("path")) {
    answer["plan_csv"] = session::plan_csv(compensated, session::layout_of(rig));
    return answer;
  }
  const std::filesystem::path path = params::absolute_path(call);
  run_patiently(
      call.service, path,
      [path, text = session::plan_csv(compensated, session::layout_of(rig))] {
        session::write_file(path.string(), text);
      });
  answer["path"] = path.string();
  return answer;
}

/// "demo.validation", "demo.validation-2", ...
std::string free_name(db::Store& reader, const std::string& session) {
  std::set<std::string> taken;
  for (const db::SessionInfo& info : reader.list_sessions()) taken.insert(info.name);
  std::string name = session + ".validation";
  for (int i = 2; taken.contains(name); ++i) {
    name = fmt::format("{}.validation-{}", session, i);
  }
  return name;
}

studies::ValidationRequest validation_request(const Json& params) {
  studies::ValidationRequest request;
  request.set = param_or<std::string>(params, "set", request.set);
  if (!params.contains("by")) return request;
  request.by.clear();
  for (const Json& word : params["by"]) {
    const auto by = studies::compensate_by_from(word.get<std::string>());
    if (!by) {
      throw Error(
          ErrorCode::kInvalidParams,
          fmt::format("parameter 'by' cannot hold '{}'", word.get<std::string>().substr(0, 64)),
          {{"param", "by"}}, "Any of: before, kinematics, full, extended.");
    }
    if (std::ranges::find(request.by, *by) == request.by.end()) request.by.push_back(*by);
  }
  if (request.by.empty()) {
    throw Error(
        ErrorCode::kInvalidParams, "parameter 'by' is empty", {{"param", "by"}},
        "Any of: before, kinematics, full, extended.");
  }
  return request;
}

/// What is told of a running collection until it has ended.
void follow(const JobControl& control, Collection& collection) {
  constexpr auto kLookEvery = std::chrono::milliseconds(200);
  for (bool ended = false; !ended;) {
    ended = collection.wait_for_end(control.stop_token(), kLookEvery);
    const Json status = collection.status();
    std::string stage = "measuring";
    if (collect_state_of(status) == CollectState::kPaused || status["move_to_rad"].is_array()) {
      stage = fmt::format("paused: {}", status["message"].get<std::string>());
    }
    control.report(
        {.stage = std::move(stage),
         .done = status["done"].get<std::int64_t>(),
         .total = status["total"].get<std::int64_t>(),
         .eta_s = status["eta_s"].is_number() ? std::optional(status["eta_s"].get<double>())
                                              : std::nullopt});
    if (!ended && control.cancelled()) {
      collection.stop_and_wait();
      control.check();
    }
  }
}

/// What a diagnosis says of the extended model on points that were not fitted; empty: nothing.
std::optional<studies::GainRow> predicted_by(
    const std::optional<studies::DiagnosisResult>& diagnosis) {
  if (!diagnosis) return std::nullopt;
  const auto* row = studies::gain_row(*diagnosis, diagnosis::GainModel::kExtended);
  return row == nullptr ? std::nullopt : std::optional(*row);
}

/// Throws Error bad_data where this rig cannot be measured on from here.
void check_can_measure(const geometry::Rig& rig, const std::string& session) {
  if (rig.dials.empty()) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format(
            "session {} was measured by an instrument that is not connected here: this rig "
            "reads no position of the tool",
            session),
        {{"session", session}},
        "Have the joint values computed (sixdial compensate --plan), measure there, import.");
  }
  if (rig.robot.connection.empty()) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format("the rig of session {} is not connected to a robot", session),
        {{"session", session}},
        "Give rig_toml with connections, or validate on the machine that has the rig.");
  }
}

Json start_validation(const Call& call) {
  Service& service = call.service;
  const db::ResultRecord record = calibration_record(call);
  const studies::CalibrationResult calibration =
      report::calibration_from_json(Json::parse(record.json));
  report::check_may_command(calibration.warnings.value_or(std::vector<studies::Warning>()));
  const studies::ValidationRequest request = validation_request(call.params);
  const bool extended =
      std::ranges::find(request.by, studies::CompensateBy::kExtended) != request.by.end();
  std::optional<db::ResultRecord> extending;
  if (extended) extending = extending_record(call);
  std::optional<studies::DiagnosisResult> diagnosis;
  if (extending) diagnosis = report::diagnosis_from_json(Json::parse(extending->json));
  if (extending && !params::from_other_session(call.params)) {
    check_session(*extending, record.session, calibration.inputs.session);
  }
  const session::Session calibrated = service.reader().load_session(record.session);
  const auto rig_text = param_or<std::string>(call.params, "rig_toml", calibrated.rig_text);
  session::Plan plan = studies::validation_plan(
      calibrated, calibration, request, diagnosis ? &*diagnosis : nullptr);
  const auto wanted = param_or<std::string>(call.params, "name", "");
  if (!wanted.empty()) check_session_name(wanted);
  if (service.collection().active()) {
    throw Error(
        ErrorCode::kWrongState, "the rig is in use: a session is being collected", {},
        "Wait for its end, or stop it: collect.stop.");
  }
  check_can_measure(session::parse_rig(rig_text, "rig.toml"), calibrated.name);
  const std::string name =
      wanted.empty() ? free_name(service.reader(), calibrated.name) : wanted;

  Job job;
  job.kind = "validation";
  job.session = calibrated.name;
  job.caller = call.caller;
  job.params = call.params;
  job.params.erase("rig_toml");
  const Job started = service.jobs().start(
      std::move(job),
      [&service, calibrated, calibration, request, predicted = predicted_by(diagnosis),
       diagnosis_id = extending ? std::optional(extending->id.value) : std::nullopt,
       plan = std::move(plan), rig_text, name, calibration_id = record.id, caller = call.caller,
       id = record.session](const JobControl& control, const Job& self) {
        const db::SessionId measured = service.store().create_session(
            name, rig_text, to_operator(caller),
            fmt::format(
                "validation of session {} by result {}", calibrated.name,
                calibration_id.value));
        static_cast<void>(
            service.collection().start({.session = name, .plan = plan, .caller = caller}));
        follow(control, service.collection());
        const Json status = service.collection().status();
        if (status["session"] != name || collect_state_of(status) != CollectState::kDone) {
          throw Error(
              ErrorCode::kJobFailed,
              fmt::format(
                  "the measurement of {} ended {} with {} of {} points", name,
                  status["state"].get<std::string>(), status["done"].get<std::int64_t>(),
                  status["total"].get<std::int64_t>()),
              {{"session", name}}, "What was measured stays in that session; start again.");
        }
        studies::ValidationResult validated = studies::validation_result(
            calibrated, calibration, service.reader().load_session(measured), request,
            predicted);
        validated.inputs.calibration_result = calibration_id.value;
        validated.inputs.diagnosis_result = diagnosis_id;
        validated.troubles = report::not_measured_from_json(status["troubles"]);
        return save_document(
            service, self, id, report::to_json(validated),
            {{"set", request.set}, {"validation_session", name}}, validated.inputs.data_hash);
      });
  return to_json(started);
}

constexpr Param kSession{
    .name = "session", .doc = "its newest calibration is used, unless `result` says which"};
constexpr Param kResult{
    .name = "result", .type = ParamType::kInteger, .doc = "number of a calibration", .min = 1};
constexpr std::array<std::string_view, 4> kWays{"before", "kinematics", "full", "extended"};
constexpr Param kBy{
    .name = "by",
    .doc =
        "before: nominal parameters; kinematics: identified ones; full: with the learned "
        "residual; extended: robot and named causes of a diagnosis; default full",
    .one_of = kWays};
constexpr Param kDiagnosis{
    .name = "diagnosis",
    .type = ParamType::kInteger,
    .doc = "number of a diagnosis, of by extended; default: the newest of the session",
    .min = 1};
constexpr Param kTemperature{
    .name = "temperature_c",
    .type = ParamType::kNumber,
    .doc = "of by extended: when it is commanded; default: at the end of the session",
    .min = -50,
    .max = 100};
constexpr Param side(std::string_view name, std::string_view doc) {
  return {.name = name, .type = ParamType::kInteger, .doc = doc, .min = -1, .max = 1};
}
constexpr Param coordinate(std::string_view name) {
  return {
      .name = name,
      .type = ParamType::kNumber,
      .required = true,
      .doc = "of the target, table frame",
      .min = -1e5,
      .max = 1e5};
}
constexpr std::array kTargetParams{
    kSession,
    kResult,
    coordinate("x_mm"),
    coordinate("y_mm"),
    kBy,
    Param{
        .name = "mode",
        .doc = "working mode; default: the rig's",
        .one_of = params::kModeWords},
    kDiagnosis,
    params::kFromOtherSession,
    kTemperature,
    side("approach1", "of by extended: 1 where joint 1 arrives turning up, -1 down, 0 unknown"),
    side("approach2", "the same of joint 2")};
constexpr std::array kPlanParams{
    kSession,
    kResult,
    Param{.name = "plan_csv", .required = true, .doc = "text of a plan file"},
    kBy,
    Param{.name = "path", .doc = "absolute path of a plan file to write instead of plan_csv"},
    kDiagnosis,
    params::kFromOtherSession,
    kTemperature};
constexpr std::array kValidateParams{
    kSession,
    kResult,
    Param{.name = "set", .doc = "whose targets are commanded again; default G2"},
    Param{
        .name = "by",
        .type = ParamType::kStringList,
        .doc = "any of before, kinematics, full, extended; default the first three; each "
               "target in all ways in turn"},
    kDiagnosis,
    params::kFromOtherSession,
    Param{.name = "name", .doc = "of the new session; default: <session>.validation"},
    Param{
        .name = "rig_toml",
        .doc = "text of a rig file with today's connections; default: the session's own rig"}};

constexpr std::array kMethods{
    RpcMethod{
        .name = "compensate.target",
        .summary = "The joint angles to command so that the calibrated robot reaches a target.",
        .params = kTargetParams,
        .result = "target_mm, mode, by, theta_rad, nominal_theta_rad, closure_mm, iterations, "
                  "result, warnings, outside_measured {farthest_mm (0: inside of what was "
                  "measured), points, points_of_new_mode, words}",
        .example = R"({"session": "demo", "x_mm": 28.0, "y_mm": 48.0})",
        .run = target},
    RpcMethod{
        .name = "compensate.plan",
        .summary = "A plan with the joint angles to command for each of its targets.",
        .params = kPlanParams,
        .result = "result, points, warnings, outside_measured (as compensate.target), and "
                  "plan_csv or path",
        .example =
            R"({"session": "demo", "plan_csv": "set,point,target_x_mm,target_y_mm\nG2,0,28,48\n"})",
        .runs_on = RunsOn::kFiles,
        .run = plan},
    RpcMethod{
        .name = "validate.start",
        .summary = "Commands the targets of a set on the robot before, after kinematics, after "
                   "ANFIS and by the extended model of a diagnosis, measures them into a "
                   "session of its own, and stores the error "
                   "reached. A job; answers at once.",
        .params = kValidateParams,
        .result = "as job.status; the job's result is a sixdial.validation document",
        .example = R"({"session": "demo", "set": "G2", "by": ["before", "full"]})",
        .run = start_validation},
};

}  // namespace

std::span<const RpcMethod> compensation_methods() { return kMethods; }

}  // namespace sixdial::service
