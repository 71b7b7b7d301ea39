// Validation on the robot: the targets of a set commanded in each way, a pass for each.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "report/documents/calibration_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/validation_json.h"
#include "report/documents/warnings_document.h"
#include "service/document_job.h"
#include "service/methods/shared_params.h"
#include "service/result_lookup.h"
#include "service/session_name.h"
#include "service/store_json.h"
#include "session/live_channels.h"
#include "session/rig_file.h"
#include "studies/stored_warnings.h"

namespace sixdial::service {
namespace {

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

/// Where nothing else is asked for, the three ways of every calibration, and what the session's
/// diagnosis can command by.
studies::ValidationRequest validation_request(
    const Json& params, const studies::DiagnosisResult* diagnosis) {
  studies::ValidationRequest request;
  request.set = param_or<std::string>(params, "set", request.set);
  if (!params.contains("by")) {
    if (diagnosis == nullptr || diagnosis->extended_fit.effects.empty()) return request;
    request.by.push_back(studies::CompensateBy::kExtended);
    if (diagnosis->extended_fit.residual_model) {
      request.by.push_back(studies::CompensateBy::kExtendedFull);
    }
    return request;
  }
  request.by.clear();
  for (const Json& word : params["by"]) {
    const auto by = studies::compensate_by_from(word.get<std::string>());
    if (!by) {
      throw Error(
          ErrorCode::kInvalidParams,
          fmt::format("parameter 'by' cannot hold '{}'", word.get<std::string>().substr(0, 64)),
          {{"param", "by"}}, "Any of: before, kinematics, full, extended, extended_full.");
    }
    if (std::ranges::find(request.by, *by) == request.by.end()) request.by.push_back(*by);
  }
  if (request.by.empty()) {
    throw Error(
        ErrorCode::kInvalidParams, "parameter 'by' is empty", {{"param", "by"}},
        "Any of: before, kinematics, full, extended, extended_full.");
  }
  return request;
}

/// What is told of a running collection until it has ended: `before` points of `all` were
/// measured in passes before it.
void follow(
    const JobControl& control, Collection& collection, std::int64_t before, std::int64_t all) {
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
         .done = before + status["done"].get<std::int64_t>(),
         .total = all,
         .eta_s = status["eta_s"].is_number() ? std::optional(status["eta_s"].get<double>())
                                              : std::nullopt});
    if (!ended && control.cancelled()) {
      collection.stop_and_wait();
      control.check();
    }
  }
}

/// Throws Error bad_data where this rig cannot be measured on from here.
void check_can_measure(const geometry::Rig& rig, const std::string& session) {
  if (session::has_live_channels(rig) && !session::has_live_positions(rig)) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format(
            "the instrument of session {} shows distances or touches and no position of the "
            "tool: what each model reaches cannot be measured by it",
            session),
        {{"session", session}},
        "The report compares the models on the points that were not fitted (G2).");
  }
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

/// What a validation commands, and by what.
struct Validated {
  session::Session calibrated;
  studies::CalibrationResult calibration;
  std::optional<studies::DiagnosisResult> diagnosis{};
  std::int64_t calibration_number = 0;
  std::optional<std::int64_t> diagnosis_number{};
  studies::ValidationRequest request{};
  std::string rig_text{}, name{};  // of the session that will hold what is measured

  [[nodiscard]] const studies::DiagnosisResult* diagnosed() const {
    return diagnosis ? &*diagnosis : nullptr;
  }
};

/// Throws Error where a way of the request needs a diagnosis and there is none.
Validated validated(const Call& call, const db::ResultRecord& record) {
  db::Store& reader = call.service.reader();
  Validated result{
      .calibrated = reader.load_session(record.session),
      .calibration = report::calibration_from_json(Json::parse(record.json)),
      .calibration_number = record.id.value};
  studies::judge_stored(result.calibration, result.calibrated);
  report::check_may_command(
      result.calibration.warnings.value_or(std::vector<studies::Warning>()));
  std::optional<db::ResultRecord> extending;
  if (call.params.contains("diagnosis")) {
    extending = extending_record(call);
  } else {
    extending = companion_of(reader, record, "diagnosis");
  }
  const auto take_diagnosis = [&] {
    result.diagnosis = report::diagnosis_from_json(Json::parse(extending->json));
    result.diagnosis_number = extending->id.value;
  };
  if (extending) take_diagnosis();
  result.request = validation_request(call.params, result.diagnosed());
  const bool extended = std::ranges::any_of(result.request.by, studies::is_extended);
  if (extended && extending && !params::from_other_session(call.params)) {
    check_session(*extending, record.session, result.calibration.inputs.session);
  }
  if (extended && !extending) {
    extending = extending_record(call);
    take_diagnosis();
  }
  if (!extended) {
    result.diagnosis.reset();
    result.diagnosis_number.reset();
  }
  result.rig_text = param_or<std::string>(call.params, "rig_toml", result.calibrated.rig_text);
  return result;
}

/// One way's pass, measured into the session; its points that could not be had go to
/// `troubles`.
session::Plan measure_pass(
    Service& service, const JobControl& control, const Validated& what, db::SessionId measured,
    studies::CompensateBy by, const Caller& caller, std::int64_t before,
    std::vector<studies::NotMeasured>& troubles) {
  const studies::PlanMoment moment = studies::moment_of_pass(
      what.calibrated, service.reader().load_session(measured), service.clock().now_utc());
  session::Plan pass = studies::validation_pass(
      what.calibrated, what.calibration, what.request, by, what.diagnosed(), moment);
  const auto points = static_cast<std::int64_t>(pass.points.size());
  static_cast<void>(
      service.collection().start({.session = what.name, .plan = pass, .caller = caller}));
  follow(control, service.collection(), before, points * std::ssize(what.request.by));
  const Json status = service.collection().status();
  if (status["session"] != what.name || collect_state_of(status) != CollectState::kDone) {
    throw Error(
        ErrorCode::kJobFailed,
        fmt::format(
            "the measurement of {} ended {} with {} of {} points of the pass '{}'", what.name,
            status["state"].get<std::string>(), status["done"].get<std::int64_t>(), points,
            studies::to_string(by)),
        {{"session", what.name}}, "What was measured stays in that session; start again.");
  }
  for (const auto& each : report::not_measured_from_json(status["troubles"])) {
    troubles.push_back(each);
  }
  return pass;
}

/// Each way in a pass of its own (studies/validate.h).
studies::ValidationResult measure(
    Service& service, const JobControl& control, const Validated& what, const Caller& caller) {
  const db::SessionId measured = service.store().create_session(
      what.name, what.rig_text, to_operator(caller),
      fmt::format(
          "validation of session {} by result {}", what.calibrated.name,
          what.calibration_number));
  session::Plan all;
  std::vector<studies::NotMeasured> troubles;
  for (const studies::CompensateBy by : what.request.by) {
    const session::Plan pass = measure_pass(
        service, control, what, measured, by, caller, std::ssize(all.points), troubles);
    all.points.insert(all.points.end(), pass.points.begin(), pass.points.end());
  }
  service.store().save_plan(measured, all);
  studies::ValidationResult result = studies::validation_result(
      what.calibrated, what.calibration, service.reader().load_session(measured), what.request,
      what.diagnosed());
  result.inputs.calibration_result = what.calibration_number;
  result.inputs.diagnosis_result = what.diagnosis_number;
  result.troubles = std::move(troubles);
  return result;
}

Json start_validation(const Call& call) {
  Service& service = call.service;
  const db::ResultRecord record = calibration_record(call);
  Validated what = validated(call, record);
  // Says now, not after the first pass, what cannot be commanded.
  static_cast<void>(studies::validation_plan(
      what.calibrated, what.calibration, what.request, what.diagnosed()));
  const auto wanted = param_or<std::string>(call.params, "name", "");
  if (!wanted.empty()) check_session_name(wanted);
  if (service.collection().active()) {
    throw Error(
        ErrorCode::kWrongState, "the rig is in use: a session is being collected", {},
        "Wait for its end, or stop it: collect.stop.");
  }
  check_can_measure(session::parse_rig(what.rig_text, "rig.toml"), what.calibrated.name);
  what.name = wanted.empty() ? free_name(service.reader(), what.calibrated.name) : wanted;

  Job job;
  job.kind = "validation";
  job.session = what.calibrated.name;
  job.caller = call.caller;
  job.params = call.params;
  job.params.erase("rig_toml");
  const Job started = service.jobs().start(
      std::move(job), [&service, what = std::move(what), caller = call.caller,
                       id = record.session](const JobControl& control, const Job& self) {
        const studies::ValidationResult result = measure(service, control, what, caller);
        return save_document(
            service, self, id, report::to_json(result),
            {{"set", what.request.set}, {"validation_session", what.name}},
            result.inputs.data_hash);
      });
  return to_json(started);
}

constexpr std::array kValidateParams{
    Param{
        .name = "session", .doc = "its newest calibration is used, unless `result` says which"},
    Param{
        .name = "result",
        .type = ParamType::kInteger,
        .doc = "number of a calibration",
        .min = 1},
    Param{.name = "set", .doc = "whose targets are commanded again; default G2"},
    Param{
        .name = "by",
        .type = ParamType::kStringList,
        .doc = "any of before, kinematics, full, extended, extended_full, each in a pass of "
               "its own; default: the first three, and those of a diagnosis that there is"},
    Param{
        .name = "diagnosis",
        .type = ParamType::kInteger,
        .doc = "number of a diagnosis, of by extended; default: the newest of the session",
        .min = 1},
    params::kFromOtherSession,
    Param{.name = "name", .doc = "of the new session; default: <session>.validation"},
    Param{
        .name = "rig_toml",
        .doc = "text of a rig file with today's connections; default: the session's own rig"}};

constexpr std::array kMethods{
    RpcMethod{
        .name = "validate.start",
        .summary = "Commands the targets of a set on the robot before, after kinematics, after "
                   "ANFIS and by the models of a diagnosis, each in a pass of its own with "
                   "stated sides of arrival, measures them into a session of its own, and "
                   "stores the error reached. A job; answers at once.",
        .params = kValidateParams,
        .result = "as job.status; the job's result is a sixdial.validation document",
        .example = R"({"session": "demo", "set": "G2", "by": ["before", "full"]})",
        .run = start_validation},
};

}  // namespace

std::span<const RpcMethod> validation_methods() { return kMethods; }

}  // namespace sixdial::service
