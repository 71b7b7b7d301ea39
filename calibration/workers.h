// A few threads that do the same job on different shares, over and over, with a short wait
// between: one iteration of a swarm is some ten microseconds.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
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
  /// Calls job(share) once for each share 0 .. count()-1 and returns when all are done. An
  /// exception of a job is thrown here (the one of the lowest share).
  void run(const std::function<void(int)>& job);

 private:
  void serve(int share);

  std::vector<std::thread> threads_;
  const std::function<void(int)>* job_ = nullptr;
  std::vector<std::exception_ptr> failures_;
  std::atomic<int> round_{0};
  std::atomic<int> busy_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace sixdial::calibration
