#include "service/store_json.h"

#include <algorithm>

namespace sixdial::service {
namespace {

JobState from_db(db::JobState state) {
  switch (state) {
    case db::JobState::kQueued:
      return JobState::kQueued;
    case db::JobState::kRunning:
      return JobState::kRunning;
    case db::JobState::kDone:
      return JobState::kDone;
    case db::JobState::kFailed:
      return JobState::kFailed;
    case db::JobState::kCancelled:
      return JobState::kCancelled;
  }
  return JobState::kFailed;
}

Json parsed_or(const std::string& text, const Json& otherwise) {
  if (text.empty()) return otherwise;
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? otherwise : json;
}

JobProgress progress_from(const Json& json) {
  JobProgress progress;
  if (!json.is_object()) return progress;
  progress.stage = json.value("stage", "");
  progress.done = json.value("done", std::int64_t{0});
  progress.total = json.value("total", std::int64_t{0});
  if (json.contains("best_mm") && json["best_mm"].is_number()) {
    progress.best_mm = json["best_mm"].get<double>();
  }
  return progress;
}

}  // namespace

db::Operator to_operator(const Caller& caller) {
  db::Operator who;
  who.name = caller.operator_name;
  if (caller.uid >= 0) who.uid = caller.uid;
  if (caller.pid >= 0) who.pid = caller.pid;
  return who;
}

Caller to_caller(const db::Operator& who) {
  return {.operator_name = who.name, .uid = who.uid.value_or(-1), .pid = who.pid.value_or(-1)};
}

db::JobState to_db(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return db::JobState::kQueued;
    case JobState::kRunning:
      return db::JobState::kRunning;
    case JobState::kDone:
      return db::JobState::kDone;
    case JobState::kFailed:
      return db::JobState::kFailed;
    case JobState::kCancelled:
      return db::JobState::kCancelled;
  }
  return db::JobState::kFailed;
}

Job job_from(const db::JobRecord& record, db::Store& store) {
  Job job;
  job.id = record.id.value;
  job.kind = record.kind;
  if (record.session) {
    job.session = store.session_info(*record.session).name;
    for (const db::ResultRecord& result : store.load_results(*record.session)) {
      if (result.job == record.id) job.result_id = result.id.value;
    }
  }
  job.caller = to_caller(record.who);
  job.params = parsed_or(record.request, Json::object());
  job.state = from_db(record.state);
  job.progress = progress_from(parsed_or(record.progress, nullptr));
  job.created_utc = record.created_utc;
  job.started_utc = record.started_utc.value_or("");
  job.finished_utc = record.finished_utc.value_or("");
  if (!record.error.empty()) {
    job.error = parsed_or(record.error, Json{{"message", record.error}});
  }
  return job;
}

Json to_json(const db::SessionInfo& info) {
  return {
      {"name", info.name},
      {"number", info.id.value},
      {"origin", info.origin},
      {"note", info.note},
      {"created_utc", info.created_utc},
      {"operator", info.who.name},
      {"version", info.program_version},
      {"rig_hash", "sha256:" + info.rig_sha256},
      {"samples", info.sample_count},
      {"samples_by_set", info.samples},
      {"plan_points", info.planned},
      {"rejected_rows", info.rejected},
      {"results", info.results},
      {"first_utc", info.first_utc ? Json(*info.first_utc) : Json(nullptr)},
      {"last_utc", info.last_utc ? Json(*info.last_utc) : Json(nullptr)}};
}

Json to_json(const db::ResultRecord& record, const std::string& session) {
  return {
      {"result", record.id.value},
      {"kind", record.kind},
      {"session", session},
      {"job", record.job ? Json(record.job->value) : Json(nullptr)},
      {"created_utc", record.created_utc},
      {"seed", record.seed},
      {"version", record.program_version},
      {"rig_hash", "sha256:" + record.rig_sha256},
      {"data_hash", "sha256:" + record.data_sha256},
      {"bytes", record.json.size()}};
}

Json readings_within_json(const session::Session& session) {
  const auto within = session::readings_within(session);
  if (!within) return nullptr;
  return {{"median", within->median_ms}, {"max", within->max_ms}};
}

}  // namespace sixdial::service
