// What the socket and the command table work on: events, jobs, the store, the collection.
// Without Asio, so that it can be driven by a test or by a program of its own.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "acquisition/clock.h"
#include "db/store.h"
#include "service/collection.h"
#include "service/dial_watch.h"
#include "service/job_board.h"
#include "service/methods/method.h"
#include "service/socket/event_hub.h"
#include "session/session.h"

namespace sixdial::service {

struct ServiceOptions {
  std::filesystem::path database{};
  double clock_speed = 1.0;  // seconds of the rig for one on the wall clock
  std::optional<session::TimePoint> clock_start{};  // what the rig's clock begins with
  std::shared_ptr<acquisition::Clock> clock{};      // instead, for tests
  bool allow_exec = false;  // a rig file may name a program that moves the robot
};

class Service {
 public:
  explicit Service(ServiceOptions options);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  [[nodiscard]] EventHub& events() { return events_; }
  /// The rig's clock: samples carry its time.
  [[nodiscard]] const acquisition::Clock& clock() const { return *clock_; }
  [[nodiscard]] JobBoard& jobs() { return jobs_; }
  [[nodiscard]] Collection& collection() { return collection_; }
  [[nodiscard]] DialWatch& dial_watch() { return dial_watch_; }
  /// The one connection that writes.
  [[nodiscard]] db::Store& store() { return store_; }
  /// Another connection, for reading: it never holds up a sample that is being stored.
  [[nodiscard]] db::Store& reader() { return reader_; }
  /// A job of this or an earlier run. Throws Error not_found.
  [[nodiscard]] Job job(std::int64_t id);
  /// The newest first; `session` empty: of all sessions.
  [[nodiscard]] std::vector<Job> recent_jobs(const std::string& session, std::int64_t limit);
  [[nodiscard]] bool stopping() const { return stopping_.load(); }

  /// `event`: each event in order; `changed`: something that a Wait looks at has changed;
  /// `shut_down`: a client asked for the end. From any thread; empty: none.
  void set_listeners(
      std::function<void(const EventPtr&)> event, std::function<void()> changed,
      std::function<void()> shut_down);
  void announce_change();
  void request_shut_down();

  /// Rolls back the point in hand, ends the dial watch, cancels the jobs, waits for all, and
  /// moves the write-ahead log into the database.
  void stop();

 private:
  [[nodiscard]] JobRecorder recorder();

  const ServiceOptions options_;
  std::shared_ptr<acquisition::Clock> clock_;
  db::Store store_;
  db::Store reader_;
  EventHub events_;
  std::atomic<bool> stopping_ = false;
  std::mutex listener_mutex_;
  std::function<void()> changed_, shut_down_;
  JobBoard jobs_;
  DialWatch dial_watch_;
  Collection collection_;
};

}  // namespace sixdial::service
