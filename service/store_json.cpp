#include "service/store_json.h"

#include <algorithm>

namespace sixdial::service {
namespace {

Json parsed_or(const std::string& text, const Json& otherwise) {
  if (text.empty()) return otherwise;
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? otherwise : json;
}

/// As it was stored last; that of a job which ended has no time left.
studies::Progress stored_progress(const Json& json) {
  studies::Progress progress;
  if (!json.is_object() || !json.contains("stage")) return progress;  // it never began
  progress = progress_from_json(json);
  progress.eta_s.reset();
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
  job.state = record.state;
  job.progress = stored_progress(parsed_or(record.progress, nullptr));
  job.created_utc = record.created_utc;
  job.started_utc = record.started_utc;
  job.finished_utc = record.finished_utc;
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
