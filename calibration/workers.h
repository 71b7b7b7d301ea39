// A few threads that share out the tasks of one short job after another: one iteration of a
// swarm is some ten microseconds. Whoever is free takes the next task, the caller included, so
// a thread that the system has set aside holds nobody up unless it is in the middle of a task.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace sixdial::calibration {

class Workers {
 public:
  /// `threads` in all, the caller included; 1 starts none.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  [[nodiscard]] int count() const { return static_cast<int>(threads_.size()) + 1; }
  /// Calls job(task) once for each task 0 .. tasks-1, in order where there is one thread, and
  /// returns when all are done. An exception of a task is thrown here (the one of the lowest
  /// task). Fewer than 2^20 tasks.
  void run(int tasks, const std::function<void(int)>& job);

 private:
  void serve();
  /// Takes tasks until there are none left.
  void work();

  std::vector<std::thread> threads_;
  const std::function<void(int)>* job_ = nullptr;
  std::vector<std::exception_ptr> failures_;  // by task
  /// How many tasks the job has and which is next, in one word: what is taken belongs to the
  /// job that is read with it.
  std::atomic<std::uint64_t> ticket_{0};
  std::atomic<int> round_{0};  // counts jobs; what idle threads watch
  std::atomic<int> left_{0};   // tasks not done yet
  std::atomic<bool> stop_{false};
};

}  // namespace sixdial::calibration
