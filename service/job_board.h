// Long work: each job gets a number at once. All jobs run on one thread of their own, one after
// the other; a job says how far it is, can be cancelled, and outlives the client that asked for
// it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "service/error.h"
#include "service/job.h"
#include "service/socket/event_hub.h"

namespace sixdial::service {

/// What the work is handed: where it reports and where it learns that it should end.
class JobControl {
 public:
  JobControl(std::stop_token stop, studies::ProgressCallback report)
      : stop_(std::move(stop)), report_(std::move(report)) {}
  [[nodiscard]] bool cancelled() const { return stop_.stop_requested(); }
  [[nodiscard]] const std::stop_token& stop_token() const { return stop_; }
  /// Throws Error cancelled if so.
  void check() const;
  void report(studies::Progress progress) const { report_(std::move(progress)); }

 private:
  std::stop_token stop_;
  studies::ProgressCallback report_;
};

/// Stores jobs; called from the job thread and from callers of the board.
struct JobRecorder {
  /// Stores a new job and gives its number.
  std::function<std::int64_t(const Job&)> create;
  /// Stores its present state (at starts and ends, not at each progress).
  std::function<void(const Job&)> update;
};

class JobBoard {
 public:
  /// The work gives the number of the stored result.
  using Work = std::function<std::int64_t(const JobControl&, const Job&)>;

  JobBoard(EventHub& events, JobRecorder recorder);
  ~JobBoard();  // stop()
  JobBoard(const JobBoard&) = delete;
  JobBoard& operator=(const JobBoard&) = delete;

  [[nodiscard]] Job start(Job job, Work work);
  /// A job of this run of the service; empty for an older one.
  [[nodiscard]] std::optional<Job> find(std::int64_t id) const;
  [[nodiscard]] std::vector<Job> list() const;
  /// Asks a job to end; one in the queue ends at once. False: it had ended already.
  bool cancel(std::int64_t id);
  /// Called after each change of a job's state or progress, from any thread.
  void set_listener(std::function<void()> listener);
  /// Cancels all and waits for the job thread.
  void stop();

 private:
  struct Entry {
    Job job;
    Work work;
    std::stop_source stop;
    std::chrono::steady_clock::time_point stage_began;
    std::chrono::steady_clock::time_point last_told;
  };
  void run();
  void run_one(Entry& entry);
  void report(Entry& entry, studies::Progress progress);
  void finish(Entry& entry, JobState state, Json error, std::optional<std::int64_t> result_id);
  void changed(const Job& job, std::string_view type);

  EventHub& events_;
  const JobRecorder recorder_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::map<std::int64_t, std::unique_ptr<Entry>> entries_;
  std::deque<std::int64_t> queue_;
  std::function<void()> listener_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace sixdial::service
