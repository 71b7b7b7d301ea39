#include "service/job_board.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "session/clock_text.h"
#include "studies/error.h"

namespace sixdial::service {
namespace {

using Steady = std::chrono::steady_clock;
constexpr auto kTellEvery = std::chrono::milliseconds(100);

/// The work ended because it was asked to.
bool was_cancelled(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    return error.code() == ErrorCode::kCancelled;
  } catch (const studies::StudyError& error) {
    return error.code() == studies::StudyErrorCode::kCancelled;
  } catch (...) {
    return false;
  }
}

}  // namespace

void JobControl::check() const {
  if (cancelled()) throw Error(ErrorCode::kCancelled, "the job was cancelled");
}

JobBoard::JobBoard(EventHub& events, JobRecorder recorder)
    : events_(events), recorder_(std::move(recorder)), thread_([this] { run(); }) {}

JobBoard::~JobBoard() { stop(); }

Job JobBoard::start(Job job, Work work) {
  job.state = JobState::kQueued;
  job.created_utc = session::now_utc_text();
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) throw Error(ErrorCode::kShuttingDown, "no job is taken while going down");
  }
  job.id = recorder_.create(job);
  Entry* made = nullptr;
  {
    const std::lock_guard lock(mutex_);
    auto entry = std::make_unique<Entry>();
    entry->job = job;
    entry->work = std::move(work);
    made = entry.get();
    entries_.emplace(job.id, std::move(entry));
  }
  // Told before the job thread can take it: "queued" comes before "started".
  changed(job, "queued");
  bool too_late = false;
  {
    const std::lock_guard lock(mutex_);
    too_late = stopping_;  // the job thread may have ended
    if (!too_late) queue_.push_back(job.id);
  }
  if (too_late) {
    const auto cancelled = std::make_exception_ptr(
        Error(ErrorCode::kCancelled, "the service went down before the job began"));
    finish(*made, JobState::kCancelled, to_error_object(cancelled), std::nullopt);
  }
  wake_.notify_one();
  return job;
}

std::optional<Job> JobBoard::find(std::int64_t id) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return std::nullopt;
  return found->second->job;
}

std::vector<Job> JobBoard::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<Job> jobs;
  for (const auto& [id, entry] : entries_) jobs.push_back(entry->job);
  return jobs;
}

bool JobBoard::cancel(std::int64_t id) {
  Entry* waiting = nullptr;
  {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(id);
    if (found == entries_.end() || is_final(found->second->job.state)) return false;
    found->second->stop.request_stop();
    const auto queued = std::ranges::find(queue_, id);
    if (queued != queue_.end()) {
      queue_.erase(queued);
      waiting = found->second.get();
    }
  }
  if (waiting != nullptr) {
    const auto cancelled = std::make_exception_ptr(
        Error(ErrorCode::kCancelled, "the job was cancelled before it began", {{"job", id}}));
    finish(*waiting, JobState::kCancelled, to_error_object(cancelled), std::nullopt);
  }
  return true;
}

void JobBoard::set_listener(std::function<void()> listener) {
  const std::lock_guard lock(mutex_);
  listener_ = std::move(listener);
}

void JobBoard::stop() {
  std::vector<std::int64_t> open;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (const auto& [id, entry] : entries_) {
      if (!is_final(entry->job.state)) open.push_back(id);
    }
  }
  for (const std::int64_t id : open) cancel(id);
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void JobBoard::run() {
  for (;;) {
    Entry* next = nullptr;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !queue_.empty(); });
      if (queue_.empty()) return;
      next = entries_.at(queue_.front()).get();
      queue_.pop_front();
    }
    run_one(*next);
  }
}

void JobBoard::run_one(Entry& entry) {
  Job job;
  {
    const std::lock_guard lock(mutex_);
    entry.job.state = JobState::kRunning;
    entry.job.started_utc = session::now_utc_text();
    entry.stage_began = Steady::now();
    job = entry.job;
  }
  const JobControl control(entry.stop.get_token(), [this, &entry](studies::Progress progress) {
    report(entry, std::move(progress));
  });
  try {
    recorder_.update(job);
    changed(job, "started");
    control.check();
    const std::int64_t result_id = entry.work(control, job);
    finish(entry, JobState::kDone, nullptr, result_id);
  } catch (...) {
    const bool cancelled = was_cancelled(std::current_exception());
    finish(
        entry, cancelled ? JobState::kCancelled : JobState::kFailed,
        to_error_object(std::current_exception()), std::nullopt);
  }
}

void JobBoard::report(Entry& entry, studies::Progress progress) {
  Job job;
  {
    const std::lock_guard lock(mutex_);
    const auto now = Steady::now();
    const bool new_stage = progress.stage != entry.job.progress.stage;
    if (new_stage) entry.stage_began = now;
    if (!progress.eta_s && progress.done > 0 && progress.total > progress.done) {
      const std::chrono::duration<double> spent = now - entry.stage_began;
      progress.eta_s = spent.count() * static_cast<double>(progress.total - progress.done) /
                       static_cast<double>(progress.done);
    }
    const bool last = progress.done == progress.total;
    entry.job.progress = std::move(progress);
    if (!new_stage && !last && now - entry.last_told < kTellEvery) return;
    entry.last_told = now;
    job = entry.job;
  }
  changed(job, "progress");
}

void JobBoard::finish(
    Entry& entry, JobState state, Json error, std::optional<std::int64_t> result_id) {
  Job job;
  {
    const std::lock_guard lock(mutex_);
    job = entry.job;
    job.state = state;
    job.error = std::move(error);
    job.result_id = result_id;
    job.finished_utc = session::now_utc_text();
  }
  try {
    recorder_.update(job);  // stored before anyone is told
  } catch (const std::exception& trouble) {
    spdlog::error("job {}: its end could not be stored: {}", job.id, trouble.what());
  }
  {
    const std::lock_guard lock(mutex_);
    entry.job = job;
    entry.work = nullptr;
  }
  changed(job, to_string(state));
}

void JobBoard::changed(const Job& job, std::string_view type) {
  Json data = to_json(job);
  data["type"] = type;
  data.erase("params");
  events_.publish("job", std::move(data));
  std::function<void()> listener;
  {
    const std::lock_guard lock(mutex_);
    listener = listener_;
  }
  if (listener) listener();
}

}  // namespace sixdial::service
