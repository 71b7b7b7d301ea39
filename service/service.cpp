#include "service/service.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace sixdial::service {

Service::Service(ServiceOptions options)
    : options_(std::move(options)),
      jobs_(
          events_,
          JobRecorder{
              .create = [next = std::int64_t{0}](const Job&) mutable { return ++next; },
              .update = [](const Job&) {}}) {
  jobs_.set_listener([this] { announce_change(); });
}

Service::~Service() { stop(); }

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
  throw Error(ErrorCode::kNotFound, fmt::format("there is no job {}", id), {{"job", id}});
}

std::vector<Job> Service::recent_jobs(const std::string& session, std::int64_t limit) {
  std::vector<Job> jobs = jobs_.list();
  std::erase_if(
      jobs, [&](const Job& job) { return !session.empty() && job.session != session; });
  std::ranges::reverse(jobs);
  if (std::ssize(jobs) > limit) jobs.resize(static_cast<std::size_t>(limit));
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
  jobs_.stop();
  announce_change();
}

}  // namespace sixdial::service
