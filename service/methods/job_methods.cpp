// Jobs: status, wait, cancel, list. Those of earlier runs of the service come from the store.
#include <fmt/format.h>

#include <array>

#include "service/service.h"

namespace sixdial::service {
namespace {

constexpr double kLongestWait_s = 600.0;

std::int64_t job_of(const Call& call) { return call.params.at("job").get<std::int64_t>(); }

Json status(const Call& call) { return to_json(call.service.job(job_of(call))); }

Wait wait(const Call& call) {
  Service& service = call.service;
  const std::int64_t id = job_of(call);
  static_cast<void>(service.job(id));  // throws not_found now, not later
  return {
      .ready = [&service, id] { return is_final(service.job(id).state); },
      .answer = [&service, id] { return to_json(service.job(id)); },
      .timeout = std::chrono::milliseconds(
          static_cast<std::int64_t>(1000.0 * param_or(call.params, "timeout_s", 60.0)))};
}

Json cancel(const Call& call) {
  const std::int64_t id = job_of(call);
  static_cast<void>(call.service.job(id));
  const bool asked = call.service.jobs().cancel(id);
  Json answer = to_json(call.service.job(id));
  answer["cancelling"] = asked;
  return answer;
}

Json list(const Call& call) {
  const auto session = param_or<std::string>(call.params, "session", "");
  const auto limit = param_or<std::int64_t>(call.params, "limit", 50);
  Json jobs = Json::array();
  for (const Job& job : call.service.recent_jobs(session, limit)) {
    Json row = to_json(job);
    row.erase("params");
    jobs.push_back(std::move(row));
  }
  return {{"jobs", std::move(jobs)}};
}

constexpr Param kJob{
    .name = "job",
    .type = ParamType::kInteger,
    .required = true,
    .doc = "number that the start method gave",
    .min = 1};
constexpr std::array kJobParams{kJob};
constexpr std::array kWaitParams{
    kJob, Param{
              .name = "timeout_s",
              .type = ParamType::kNumber,
              .doc = "answer after this long in any case; default 60",
              .min = 0,
              .max = kLongestWait_s}};
constexpr std::array kListParams{
    Param{.name = "session", .doc = "only jobs of this session"},
    Param{
        .name = "limit",
        .type = ParamType::kInteger,
        .doc = "the newest so many; default 50",
        .min = 1,
        .max = 100}};

constexpr std::string_view kJobResult =
    "job, kind, session, operator, params, state (queued, running, done, failed, cancelled), "
    "progress {stage, done, total, best_mm, eta_s}, created_utc, started_utc, "
    "finished_utc, result (number for result.get), error";

constexpr std::array kMethods{
    RpcMethod{
        .name = "job.status",
        .summary = "How far a job is, and what came of it.",
        .params = kJobParams,
        .result = kJobResult,
        .example = R"({"job": 1})",
        .run = status},
    RpcMethod{
        .name = "job.wait",
        .summary = "As job.status, but answers when the job has ended or the time is over.",
        .params = kWaitParams,
        .result = kJobResult,
        .example = R"({"job": 1, "timeout_s": 60})",
        .wait = wait},
    RpcMethod{
        .name = "job.cancel",
        .summary = "Asks a job to end; it stops at its next step.",
        .params = kJobParams,
        .result = "as job.status, and cancelling: false if it had ended already",
        .example = R"({"job": 1})",
        .run = cancel},
    RpcMethod{
        .name = "job.list",
        .summary = "The newest jobs first, also those of earlier runs of the service.",
        .params = kListParams,
        .result = "jobs [as job.status without params]",
        .example = R"({"limit": 10})",
        .run = list},
};

}  // namespace

std::span<const RpcMethod> job_methods() { return kMethods; }

}  // namespace sixdial::service
