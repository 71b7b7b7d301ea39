// A few threads that share the tasks of one short job after another; a job, such as one
// iteration of a swarm, takes some ten microseconds. Whoever is free takes the next task, also
// the caller. So a thread that the system has suspended delays the others only if it is in the
// middle of a task.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace sixdial::calibration {

/// So many threads as were asked for; for 0 as many as the machine has for this process.
[[nodiscard]] int threads_asked(int asked);

class Workers {
 public:
  /// `threads` in all, the caller included; 1 starts none.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  [[nodiscard]] int count() const { return static_cast<int>(threads_.size()) + 1; }
  /// Calls job(task) once for each task 0 .. tasks-1 and returns when all are done. The caller
  /// takes them from the first on, the others from the last: so that from job to job a task
  /// tends to stay with the thread that has its data. An exception of a task is thrown here
  /// (the one of the lowest task). Fewer than 2^20 tasks.
  void run(int tasks, const std::function<void(int)>& job);

 private:
  static constexpr std::size_t kCacheLine = 64;
  void serve();
  /// Takes tasks until there are none left.
  void work(bool from_end);

  std::vector<std::thread> threads_;
  const std::function<void(int)>* job_ = nullptr;
  std::vector<std::exception_ptr> failures_;  // by task
  /// How many tasks the job has and how many are taken from either end, in one word: what is
  /// taken belongs to the job that is read with it.
  alignas(kCacheLine) std::atomic<std::uint64_t> ticket_{0};
  alignas(kCacheLine) std::atomic<int> round_{0};  // counts jobs; what idle threads watch
  alignas(kCacheLine) std::atomic<int> left_{0};   // tasks not done yet
  std::atomic<bool> stop_{false};
};

}  // namespace sixdial::calibration
