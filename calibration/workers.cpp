#include "calibration/workers.h"

#include <exception>

namespace sixdial::calibration {
namespace {

// Looking this often before going to sleep bridges the gap between two iterations.
constexpr int kLooks = 4000;

/// Waits until `value` is no longer `old`; returns what it is then.
int wait_while(const std::atomic<int>& value, int old) {
  for (int look = 0; look < kLooks; ++look) {
    const int now = value.load(std::memory_order_acquire);
    if (now != old) return now;
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
  value.wait(old, std::memory_order_acquire);
  return value.load(std::memory_order_acquire);
}

}  // namespace

Workers::Workers(int threads) : failures_(static_cast<std::size_t>(threads < 1 ? 1 : threads)) {
  for (int share = 1; share < threads; ++share) {
    threads_.emplace_back([this, share] { serve(share); });
  }
}

Workers::~Workers() {
  stop_.store(true, std::memory_order_release);
  round_.fetch_add(1, std::memory_order_acq_rel);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Workers::run(const std::function<void(int)>& job) {
  if (threads_.empty()) {
    job(0);
    return;
  }
  for (std::exception_ptr& failure : failures_) failure = nullptr;
  job_ = &job;
  busy_.store(static_cast<int>(threads_.size()), std::memory_order_release);
  round_.fetch_add(1, std::memory_order_acq_rel);
  round_.notify_all();
  try {
    job(0);
  } catch (...) {
    failures_[0] = std::current_exception();
  }
  for (int left = busy_.load(std::memory_order_acquire); left > 0;) {
    left = wait_while(busy_, left);
  }
  for (const std::exception_ptr& failure : failures_) {
    if (failure) std::rethrow_exception(failure);
  }
}

void Workers::serve(int share) {
  int seen = 0;
  while (true) {
    seen = wait_while(round_, seen);
    if (stop_.load(std::memory_order_acquire)) return;
    try {
      (*job_)(share);
    } catch (...) {
      failures_[static_cast<std::size_t>(share)] = std::current_exception();
    }
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_all();
  }
}

}  // namespace sixdial::calibration
