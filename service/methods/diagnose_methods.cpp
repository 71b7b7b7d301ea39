// The diagnosis of a session as a job with a stored result.
#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "report/documents/diagnosis_json.h"
#include "report/sections/sections_of_studies.h"
#include "service/document_job.h"
#include "service/methods/shared_params.h"
#include "service/patient_files.h"
#include "service/result_lookup.h"
#include "service/service.h"
#include "service/study_params.h"
#include "session/csv.h"
#include "studies/diagnose.h"

namespace sixdial::service {
namespace {

Json start_diagnosis(const Call& call) {
  const studies::DiagnosisRequest request = diagnosis_request(call.params);
  return start_document_job(
      call, "diagnosis", request.seed,
      [request](
          const session::Session& session, const studies::ProgressCallback& progress,
          std::stop_token stop) {
        return report::to_json(studies::diagnose(session, request, progress, std::move(stop)));
      });
}

Json write_page(const Call& call) {
  const std::filesystem::path path = params::absolute_path(call);
  const db::ResultRecord record = diagnosis_record(call);
  db::Store& reader = call.service.reader();
  const std::string page = report::diagnosis_page(
      report::diagnosis_from_json(Json::parse(record.json)),
      reader.load_session(record.session), reader.session_info(record.session).who.name);
  run_patiently(call.service, path, [path, page] { session::write_file(path.string(), page); });
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
    params::kSession,
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
        .doc = "false: without the gain on G2, which trains networks"},
    Param{
        .name = "samples",
        .type = ParamType::kInteger,
        .doc =
            "of a session with more samples so many are drawn and used; 0: all; default 1500",
        .min = 0,
        .max = 1e7},
    params::kThreads};

constexpr std::array kMethods{
    RpcMethod{
        .name = "diagnose.report",
        .summary = "Writes the page of a diagnosis: one HTML file.",
        .params = kPageParams,
        .result = "path, result",
        .example = R"({"session": "demo", "path": "/srv/rig/diagnosis.html"})",
        .runs_on = RunsOn::kFiles,
        .run = write_page},
    RpcMethod{
        .name = "diagnose.start",
        .summary =
            "Finds what the simulation gets wrong on a session and names the cause, as a "
            "job. Answers at once.",
        .params = kParams,
        .result = "as job.status; the job's result is a sixdial.diagnosis document",
        .example = R"({"session": "demo", "seed": 7, "bootstrap": 20, "gain": false})",
        .command = "sixdial diagnose {session}",
        .run = start_diagnosis}};

}  // namespace

std::span<const RpcMethod> diagnosis_methods() { return kMethods; }

}  // namespace sixdial::service
