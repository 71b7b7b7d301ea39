// Calibration as a job, its stored results, and reports from them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "report/documents/calibration_json.h"
#include "report/documents/comparison_json.h"
#include "report/documents/recommendation_json.h"
#include "report/documents/summary.h"
#include "report/documents/warnings_document.h"
#include "report/headline.h"
#include "report/report_run.h"
#include "report/sections/against_sections.h"
#include "service/document_job.h"
#include "service/methods/shared_params.h"
#include "service/patient_files.h"
#include "service/recommended_model.h"
#include "service/result_lookup.h"
#include "service/service.h"
#include "service/store_json.h"
#include "service/study_params.h"
#include "service/text_page.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/method_name.h"
#include "studies/stored_warnings.h"

namespace sixdial::service {
namespace {

constexpr auto kReportPatience = std::chrono::minutes(5);  // its pages are made, too

Json start_calibration(const Call& call) {
  const studies::CalibrationRequest request = calibration_request(call.params);
  static_cast<void>(studies::chosen_method(request.method, "method"));
  return start_document_job(
      call, "calibration", request.seed,
      [request](
          const session::Session& session, const studies::ProgressCallback& progress,
          std::stop_token stop) {
        return report::to_json(studies::calibrate(session, request, progress, std::move(stop)));
      });
}

Json get(const Call& call) {
  const db::ResultRecord record = calibration_record(call);
  Json answer = to_json(record, call.service.reader().session_info(record.session).name);
  if (call.params.contains("path")) {
    const std::filesystem::path path = params::absolute_path(call);
    run_patiently(call.service, path, [path, json = record.json] {
      session::write_file(path.string(), json);
    });
    answer["path"] = path.string();
    return answer;
  }
  if (!call.params.contains("offset")) {
    answer["summary"] = report::document_summary(Json::parse(record.json));
    return answer;
  }
  const auto begin = call.params["offset"].get<std::size_t>();
  if (begin > record.json.size()) {
    throw Error(
        ErrorCode::kInvalidParams,
        fmt::format("offset {} is beyond the {} bytes", begin, record.json.size()),
        {{"param", "offset"}});
  }
  const std::size_t end = page_end(record.json, begin);
  answer["text"] = record.json.substr(begin, end - begin);
  answer["next_offset"] = end < record.json.size() ? Json(end) : Json(nullptr);
  return answer;
}

Json list(const Call& call) {
  db::Store& reader = call.service.reader();
  const auto name = call.params.at("session").get<std::string>();
  std::vector<db::ResultRecord> all = reader.load_results(reader.find_session(name));
  std::ranges::reverse(all);
  const auto limit = param_or<std::size_t>(call.params, "limit", 50);
  if (all.size() > limit) all.resize(limit);
  Json rows = Json::array();
  for (const db::ResultRecord& record : all) rows.push_back(to_json(record, name));
  return {{"results", std::move(rows)}};
}

Json number_or_null(const std::optional<std::int64_t>& number) {
  return number ? Json(*number) : Json(nullptr);
}

Json recommend(const Call& call) {
  const db::ResultRecord record = calibration_record(call);
  const RecommendedModel model = recommended_model(call.service.reader(), record);
  Json answer = report::to_json(model.recommendation());
  answer["calibration"] = model.calibration_number;
  answer["diagnosis"] = number_or_null(model.diagnosis_number);
  answer["validation"] = number_or_null(model.validation_number);
  answer["state"] = report::state_name(report::verdict_of(model.calibration).state);
  answer["warnings"] = report::warnings_json(
      model.calibration.warnings.value_or(std::vector<studies::Warning>()));
  return answer;
}

Json write(const Call& call) {
  const std::filesystem::path path = params::absolute_path(call);
  const db::ResultRecord record = calibration_record(call);
  db::Store& reader = call.service.reader();
  const session::Session session = reader.load_session(record.session);
  const auto comparison = companion_of(reader, record, "comparison");
  std::optional<studies::ComparisonResult> compared;
  if (comparison) compared = report::comparison_from_json(Json::parse(comparison->json));
  const RecommendedModel model = recommended_model(reader, record);
  const studies::CalibrationResult& result = model.calibration;
  std::vector<report::Section> more;
  if (const auto other_name = param_or<std::string>(call.params, "against", "");
      !other_name.empty()) {
    const Json wanted{{"session", other_name}};
    const db::ResultRecord other =
        calibration_record(Call{call.service, wanted, call.caller, call.sink});
    studies::CalibrationResult other_result =
        report::calibration_from_json(Json::parse(other.json));
    const session::Session other_session = reader.load_session(other.session);
    studies::judge_stored(other_result, other_session);
    more = report::against_sections({result, session}, {other_result, other_session});
  }
  std::optional<double> tolerance_mm;
  if (call.params.contains("tolerance_mm")) {
    tolerance_mm = call.params["tolerance_mm"].get<double>();
  }
  const std::string who = reader.session_info(record.session).who.name;
  const auto files = with_patience(
      call.service, path,
      [path, model, session, who, compared, more, tolerance_mm,
       made = call.service.clock().now_utc()] {
        return report::write_report(
            model.calibration, session, who, path,
            {.comparison = compared ? &*compared : nullptr,
             .diagnosis = model.diagnosis ? &*model.diagnosis : nullptr,
             .validation = model.validation ? &*model.validation : nullptr,
             .tolerance_mm = tolerance_mm,
             .made = made},
            more);
      },
      kReportPatience);
  return {
      {"path", path.string()},
      {"files", files},
      {"result", record.id.value},
      {"comparison", comparison ? Json(comparison->id.value) : Json(nullptr)},
      {"diagnosis", number_or_null(model.diagnosis_number)},
      {"validation", number_or_null(model.validation_number)},
      {"state", report::state_name(report::verdict_of(result).state)},
      {"warnings",
       report::warnings_json(result.warnings.value_or(std::vector<studies::Warning>()))}};
}

constexpr Param kResult{
    .name = "result",
    .type = ParamType::kInteger,
    .doc = "number of the result; left out: the newest calibration of `session`",
    .min = 1};
constexpr Param kSessionOr{.name = "session", .doc = "instead of `result`"};
constexpr std::array kCalibrateParams{
    params::kSession,
    Param{
        .name = "method",
        .doc = "any identifier, alone or with any residual model after a '+', such as lm+gp; "
               "default ekf_dqpso+anfis"},
    Param{
        .name = "profile",
        .doc = "paper: its literal choices; default: without its known faults",
        .one_of = params::kProfileWords},
    Param{
        .name = "seed",
        .type = ParamType::kInteger,
        .doc = "of the searches; the same gives the same result; default 1",
        .min = 0},
    params::kThreads,
    params::kParticles,
    params::kQpso1,
    params::kQpso2,
    params::kAnfisEpochs,
    params::kFix,
    params::kFree,
    params::kTolerance,
    params::kKeepGrossErrors};
constexpr std::array kGetParams{
    kResult, kSessionOr,
    Param{
        .name = "offset",
        .type = ParamType::kInteger,
        .doc = "a page of the document's text from this byte on, instead of the summary",
        .min = 0},
    Param{.name = "path", .doc = "absolute path of a file to write the document to"}};
constexpr std::array kRecommendParams{kResult, kSessionOr};
constexpr std::array kListParams{
    params::kSession, Param{
                          .name = "limit",
                          .type = ParamType::kInteger,
                          .doc = "the newest so many; default 50",
                          .min = 1,
                          .max = 100}};
constexpr std::array kWriteParams{
    kResult, kSessionOr,
    Param{.name = "path", .required = true, .doc = "absolute path of the report's folder"},
    Param{
        .name = "against",
        .doc = "another session, whose newest calibration is compared: as found, as left"},
    params::kTolerance};

constexpr std::array kMethods{
    RpcMethod{
        .name = "calibrate.start",
        .summary =
            "Calibrates a session as a job: EKF, two QPSO searches, ANFIS, or by any other "
            "method. Answers at once.",
        .params = kCalibrateParams,
        .result = "as job.status",
        .example =
            R"({"session": "demo", "seed": 7, "particles": 20, "qpso1_iterations": 10, "qpso2_iterations": 40, "anfis_epochs": 20})",
        .command = "sixdial calibrate {session}",
        .run = start_calibration},
    RpcMethod{
        .name = "result.get",
        .summary =
            "A stored result: its summary, a page of the whole document, or the document "
            "as a file.",
        .params = kGetParams,
        .result =
            "result, kind, session, job, created_utc, seed, version, rig_hash, data_hash, "
            "bytes; and summary, or text and next_offset (null: the last page), or path",
        .example = R"({"session": "demo", "offset": 0})",
        .runs_on = RunsOn::kFiles,
        .run = get},
    RpcMethod{
        .name = "result.list",
        .summary = "The results of a session, newest first.",
        .params = kListParams,
        .result = "results [{result, kind, session, job, created_utc, seed, version, rig_hash, "
                  "data_hash, bytes}]",
        .example = R"({"session": "demo"})",
        .run = list},
    RpcMethod{
        .name = "result.recommend",
        .summary = "Which model to command by, with its parameters, and why: chosen within G1, "
                   "never one that a validation ruled out.",
        .params = kRecommendParams,
        .result = "a sixdial.recommendation document; calibration, diagnosis and validation "
                  "(numbers of the results that say so, or null), state, warnings",
        .example = R"({"session": "demo"})",
        .runs_on = RunsOn::kLong,
        .command = "sixdial recommend {session}",
        .run = recommend},
    RpcMethod{
        .name = "report.write",
        .summary =
            "Writes the report of a result: HTML, JSON, CSV tables, the session bundle. "
            "Shows the newest comparison and diagnosis of the same samples and the newest "
            "validation of this calibration, if there are any.",
        .params = kWriteParams,
        .result =
            "path, files, result, comparison, diagnosis and validation (numbers of those it "
            "shows, or null)",
        .example = R"({"session": "demo", "path": "/srv/rig/report"})",
        .runs_on = RunsOn::kFiles,
        .run = write},
};

}  // namespace

std::span<const RpcMethod> result_methods() { return kMethods; }

}  // namespace sixdial::service
