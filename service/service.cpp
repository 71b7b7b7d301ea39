#include "service/service.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "service/socket/request.h"
#include "service/store_json.h"

namespace sixdial::service {
namespace {

std::shared_ptr<acquisition::Clock> clock_for(const ServiceOptions& options) {
  if (options.clock) return options.clock;
  if (options.clock_speed == 1.0 && !options.clock_start) {
    return std::make_shared<acquisition::SystemClock>();
  }
  const auto now =
      std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  return std::make_shared<acquisition::AcceleratedClock>(
      options.clock_speed, options.clock_start.value_or(now));
}

db::Store open_store(const std::filesystem::path& path) {
  if (path.has_parent_path()) {
    std::error_code ignored;  // a failure shows when the database is opened
    std::filesystem::create_directories(path.parent_path(), ignored);
  }
  db::Store store = db::Store::open(path.string());
  const int cut_off =
      store.fail_unfinished_jobs(to_line(to_error_object(std::make_exception_ptr(Error(
          ErrorCode::kJobFailed, "the service ended before the job did", {},
          "Start it again.")))));
  if (cut_off > 0) spdlog::warn("{} jobs were cut off when the service last ended", cut_off);
  return store;
}

}  // namespace

Service::Service(ServiceOptions options)
    : options_(std::move(options)),
      clock_(clock_for(options_)),
      store_(open_store(options_.database)),
      reader_(db::Store::open_read_only(options_.database.string())),
      jobs_(events_, recorder()),
      dial_watch_(events_, reader_, *clock_),
      collection_(
          events_, store_, *clock_, [this] { announce_change(); },
          [this] { dial_watch_.stop(); }, options_.allow_exec) {
  jobs_.set_listener([this] { announce_change(); });
}

Service::~Service() { stop(); }

JobRecorder Service::recorder() {
  return {
      .create =
          [this](const Job& job) {
            db::NewJob row;
            row.kind = job.kind;
            if (!job.session.empty()) row.session = store_.find_session(job.session);
            row.request = to_line(job.params);
            row.who = to_operator(job.caller);
            return store_.save_job(row).value;
          },
      .update =
          [this](const Job& job) {
            db::JobUpdate update;
            update.state = job.state;
            update.progress = to_line(to_json(job.progress));
            if (!job.error.is_null()) update.error = to_line(job.error);
            store_.update_job({job.id}, update);
          }};
}

void Service::set_listeners(
    std::function<void(const EventPtr&)> event, std::function<void()> changed,
    std::function<void()> shut_down) {
  {
    const std::lock_guard lock(listener_mutex_);
    changed_ = std::move(changed);
    shut_down_ = std::move(shut_down);
  }
  events_.set_listener(std::move(event));
}

Job Service::job(std::int64_t id) {
  if (auto job = jobs_.find(id)) return *std::move(job);
  return job_from(reader_.load_job({id}), reader_);
}

std::vector<Job> Service::recent_jobs(const std::string& session, std::int64_t limit) {
  std::optional<db::SessionId> only;
  if (!session.empty()) only = reader_.find_session(session);
  std::vector<db::JobRecord> records = reader_.list_jobs(only);
  std::ranges::sort(records, std::greater{}, [](const auto& row) { return row.id.value; });
  if (std::ssize(records) > limit) records.resize(static_cast<std::size_t>(limit));
  std::vector<Job> jobs;
  for (const db::JobRecord& record : records) {
    auto known = jobs_.find(record.id.value);
    jobs.push_back(known ? *std::move(known) : job_from(record, reader_));
  }
  return jobs;
}

void Service::announce_change() {
  const std::lock_guard lock(listener_mutex_);
  if (changed_) changed_();
}

void Service::request_shut_down() {
  const std::lock_guard lock(listener_mutex_);
  if (shut_down_) shut_down_();
}

void Service::stop() {
  if (stopping_.exchange(true)) return;
  events_.publish("service", {{"type", "stopping"}});
  dial_watch_.stop();
  collection_.stop_and_wait();
  jobs_.stop();
  try {
    store_.checkpoint();
  } catch (const std::exception& trouble) {
    spdlog::error("the last checkpoint failed, nothing is lost: {}", trouble.what());
  }
  announce_change();
}

}  // namespace sixdial::service
