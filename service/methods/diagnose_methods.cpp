// The diagnosis of a session as a job with a stored result.
#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "report/documents/diagnosis_json.h"
#include "report/sections/sections_of_studies.h"
#include "service/document_job.h"
#include "service/result_lookup.h"
#include "service/service.h"
#include "session/csv.h"
#include "studies/diagnose.h"

namespace sixdial::service {
namespace {

Json start_diagnosis(const Call& call) {
  studies::DiagnosisRequest request;
  request.seed = param_or<std::uint64_t>(call.params, "seed", request.seed);
  request.bootstrap = param_or(call.params, "bootstrap", request.bootstrap);
  request.with_gain = param_or(call.params, "gain", request.with_gain);
  return start_document_job(
      call, "diagnosis", request.seed,
      [request](
          const session::Session& session, const std::function<void(JobProgress)>& progress,
          std::stop_token stop) {
        return report::to_json(studies::diagnose(session, request, progress, std::move(stop)));
      });
}

Json write_page(const Call& call) {
  const std::filesystem::path path = call.params.at("path").get<std::string>();
  if (!path.is_absolute()) {
    throw Error(
        ErrorCode::kInvalidParams, fmt::format("the path {} is relative", path.string()),
        {{"param", "path"}}, "The service runs in another directory: give an absolute path.");
  }
  const db::ResultRecord record = diagnosis_record(call);
  db::Store& reader = call.service.reader();
  session::write_file(
      path.string(),
      report::diagnosis_page(
          report::diagnosis_from_json(Json::parse(record.json)),
          reader.load_session(record.session), reader.session_info(record.session).who.name));
  return {{"path", path.string()}, {"result", record.id.value}};
}

constexpr std::array kPageParams{
    Param{
        .name = "result",
        .type = ParamType::kInteger,
        .doc = "number of a diagnosis; left out: the newest of `session`",
        .min = 1},
    Param{.name = "session", .doc = "instead of `result`"},
    Param{.name = "path", .required = true, .doc = "absolute path of the page"}};
constexpr std::array kParams{
    Param{.name = "session", .required = true, .doc = "name of the session"},
    Param{
        .name = "seed",
        .type = ParamType::kInteger,
        .doc = "of simulated noise, intervals and networks; the same gives the same; default 1",
        .min = 0},
    Param{
        .name = "bootstrap",
        .type = ParamType::kInteger,
        .doc = "simulated sessions of noise behind the false alarm probability, and a tenth of "
               "the draws of the gain's intervals; default 200",
        .min = 0,
        .max = 1e5},
    Param{
        .name = "gain",
        .type = ParamType::kBoolean,
        .doc = "false: without the gain on G2, which trains networks"}};

constexpr std::array kMethods{
    Method{
        .name = "diagnose.report",
        .summary = "Writes the page of a diagnosis: one HTML file.",
        .params = kPageParams,
        .result = "path, result",
        .example = R"({"session": "demo", "path": "/srv/rig/diagnosis.html"})",
        .run = write_page},
    Method{
        .name = "diagnose.start",
        .summary =
            "Finds what the simulation gets wrong on a session and names the cause, as a "
            "job. Answers at once.",
        .params = kParams,
        .result = "as job.status; the job's result is a sixdial.diagnosis document",
        .example = R"({"session": "demo", "seed": 7, "bootstrap": 20, "gain": false})",
        .run = start_diagnosis}};

}  // namespace

std::span<const Method> diagnosis_methods() { return kMethods; }

}  // namespace sixdial::service
