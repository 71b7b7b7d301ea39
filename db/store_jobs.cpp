// Jobs and results: long work, and what came of it from which inputs.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <utility>

#include "db/store_steps.h"
#include "session/bundle.h"

namespace sixdial::db {
namespace {

constexpr std::array<std::pair<JobState, const char*>, 5> kStates{{
    {JobState::kQueued, "queued"},
    {JobState::kRunning, "running"},
    {JobState::kDone, "done"},
    {JobState::kFailed, "failed"},
    {JobState::kCancelled, "cancelled"},
}};

constexpr const char* kJobColumns =
    "id, kind, session_id, state, request, progress, error, operator, operator_uid, "
    "operator_pid, created_utc, started_utc, finished_utc";

JobRecord job_of(const Statement& row) {
  JobRecord job;
  job.id = JobId{row.number(0)};
  job.kind = row.text(1);
  if (!row.is_null(2)) job.session = SessionId{row.number(2)};
  job.state = job_state_from(row.text(3)).value_or(JobState::kFailed);
  job.request = row.text(4);
  job.progress = row.text(5);
  job.error = row.text(6);
  job.who = {row.text(7), row.integer_or_none(8), row.integer_or_none(9)};
  job.created_utc = row.text(10);
  job.started_utc = row.text_or_none(11);
  job.finished_utc = row.text_or_none(12);
  return job;
}

constexpr const char* kResultColumns =
    "id, session_id, kind, result, settings, seed, rig_sha256, data_sha256, program_version, "
    "created_utc, job_id";

ResultRecord result_of(const Statement& row) {
  ResultRecord result;
  result.id = ResultId{row.number(0)};
  result.session = SessionId{row.number(1)};
  result.kind = row.text(2);
  result.json = row.text(3);
  result.settings = row.text(4);
  const std::string seed = row.text(5);  // as text: it may exceed SQLite's integers
  std::from_chars(seed.data(), seed.data() + seed.size(), result.seed);
  result.rig_sha256 = row.text(6);
  result.data_sha256 = row.text(7);
  result.program_version = row.text(8);
  result.created_utc = row.text(9);
  if (!row.is_null(10)) result.job = JobId{row.number(10)};
  return result;
}

std::optional<std::int64_t> value_of(const auto& id) {
  return id ? std::optional(id->value) : std::nullopt;
}

}  // namespace

const char* to_string(JobState state) {
  for (const auto& [each, name] : kStates) {
    if (each == state) return name;
  }
  return "failed";
}

std::optional<JobState> job_state_from(const std::string& text) {
  for (const auto& [each, name] : kStates) {
    if (text == name) return each;
  }
  return std::nullopt;
}

bool is_final(JobState state) {
  return state == JobState::kDone || state == JobState::kFailed ||
         state == JobState::kCancelled;
}

// Not a CHECK of the schema: SQLite refuses json_valid there once the schema is not trusted.
void Store::refuse_bad_json(const std::string& what, const std::string& json) {
  Statement query(*database_, "SELECT json_valid(?)");
  query.bind(json);
  query.step();
  if (query.integer(0) == 1) return;
  throw StoreError(StoreTrouble::kRefused, path_, what + " is not JSON", "");
}

JobId Store::save_job(const NewJob& job) {
  return writing([&] {
    if (job.session) (void)rig_of(*job.session);
    refuse_bad_json("the job's request", job.request);
    Statement(
        *database_,
        "INSERT INTO jobs (kind, session_id, state, request, operator, operator_uid, "
        "operator_pid, created_utc) VALUES (?, ?, 'queued', ?, ?, ?, ?, ?)")
        .bind(
            job.kind, value_of(job.session), job.request, job.who.name, job.who.uid,
            job.who.pid, now_utc())
        .run();
    return JobId{database_->last_row_id()};
  });
}

void Store::update_job(JobId id, const JobUpdate& update) {
  writing([&] {
    Statement query(*database_, "SELECT state FROM jobs WHERE id = ?");
    query.bind(id.value);
    if (!query.step()) not_found("job", fmt::format("there is no job number {}", id.value));
    const auto before = job_state_from(query.text(0)).value_or(JobState::kFailed);
    query.reset();
    if (is_final(before)) {
      throw StoreError(
          StoreTrouble::kRefused, path_,
          fmt::format("job {} is {} already", id.value, to_string(before)), "");
    }
    if (update.progress) refuse_bad_json("the job's progress", *update.progress);
    const JobState after = update.state.value_or(before);
    std::optional<std::string> started;
    std::optional<std::string> finished;
    if (after != JobState::kQueued) started = now_utc();
    if (is_final(after)) finished = now_utc();
    Statement(
        *database_,
        "UPDATE jobs SET state = ?, progress = coalesce(?, progress), error = coalesce(?, "
        "error), started_utc = coalesce(started_utc, ?), finished_utc = ? WHERE id = ?")
        .bind(to_string(after), update.progress, update.error, started, finished, id.value)
        .run();
  });
}

JobRecord Store::load_job(JobId id) {
  return reading([&] {
    Statement query(*database_, fmt::format("SELECT {} FROM jobs WHERE id = ?", kJobColumns));
    query.bind(id.value);
    if (!query.step()) not_found("job", fmt::format("there is no job number {}", id.value));
    return job_of(query);
  });
}

std::vector<JobRecord> Store::list_jobs(std::optional<SessionId> session) {
  return reading([&] {
    std::vector<JobRecord> jobs;
    Statement query(
        *database_, fmt::format(
                        "SELECT {} FROM jobs WHERE ?1 IS NULL OR session_id = ?1 ORDER BY id",
                        kJobColumns));
    query.bind(value_of(session));
    while (query.step()) jobs.push_back(job_of(query));
    return jobs;
  });
}

int Store::fail_unfinished_jobs(const std::string& reason) {
  return writing([&] {
    Statement(
        *database_,
        "UPDATE jobs SET state = 'failed', error = ?, finished_utc = ? "
        "WHERE state IN ('queued', 'running')")
        .bind(reason, now_utc())
        .run();
    return database_->changed_rows();
  });
}

ResultId Store::save_result(const NewResult& result) {
  return writing([&] {
    refuse_bad_json("the result", result.json);
    refuse_bad_json("the result's settings", result.settings);
    const session::Session session = session_of(result.session);
    const std::string data_hash =
        result.data_sha256.empty() ? session::data_sha256(session) : result.data_sha256;
    Statement(
        *database_,
        "INSERT INTO results (kind, session_id, job_id, rig_sha256, data_sha256, seed, "
        "program_version, settings, result, created_utc) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
        .bind(
            result.kind, result.session.value, value_of(result.job),
            session::rig_sha256(session), data_hash, std::to_string(result.seed),
            SIXDIAL_VERSION, result.settings, result.json, now_utc())
        .run();
    return ResultId{database_->last_row_id()};
  });
}

ResultRecord Store::load_result(ResultId id) {
  return reading([&] {
    Statement query(
        *database_, fmt::format("SELECT {} FROM results WHERE id = ?", kResultColumns));
    query.bind(id.value);
    if (!query.step())
      not_found("result", fmt::format("there is no result number {}", id.value));
    return result_of(query);
  });
}

std::vector<ResultRecord> Store::load_results(SessionId id, std::string_view kind) {
  return reading([&] {
    (void)rig_of(id);
    std::vector<ResultRecord> results;
    Statement query(
        *database_,
        fmt::format(
            "SELECT {} FROM results WHERE session_id = ?1 AND (?2 = '' OR kind = ?2) "
            "ORDER BY id",
            kResultColumns));
    query.bind(id.value, kind);
    while (query.step()) results.push_back(result_of(query));
    return results;
  });
}

}  // namespace sixdial::db
