#include "calibration/workers.h"

#include <algorithm>
#include <stdexcept>

namespace sixdial::calibration {
namespace {

// Looking this often before going to sleep bridges the gap between two iterations.
constexpr int kLooks = 4000;
constexpr int kTaskBits = 20;
constexpr std::uint64_t kTaskMask = (std::uint64_t{1} << kTaskBits) - 1;

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

int threads_asked(int asked) {
  return asked > 0 ? asked
                   : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

Workers::Workers(int threads) {
  // More than a machine can have only takes its memory; results do not depend on the number.
  constexpr int kMost = 256;
  threads = std::min(threads, kMost);
  for (int k = 1; k < threads; ++k) {
    threads_.emplace_back([this] { serve(); });
  }
}

Workers::~Workers() {
  stop_.store(true, std::memory_order_release);
  round_.fetch_add(1, std::memory_order_acq_rel);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Workers::run(int tasks, const std::function<void(int)>& job) {
  if (tasks < 0 || static_cast<std::uint64_t>(tasks) > kTaskMask) {
    throw std::invalid_argument("Workers: between 0 and 2^20 - 1 tasks can be shared out");
  }
  if (threads_.empty()) {
    for (int task = 0; task < tasks; ++task) job(task);
    return;
  }
  failures_.assign(static_cast<std::size_t>(tasks), nullptr);
  job_ = &job;
  left_.store(tasks, std::memory_order_relaxed);
  ticket_.store(
      static_cast<std::uint64_t>(tasks) << (2 * kTaskBits), std::memory_order_release);
  round_.fetch_add(1, std::memory_order_acq_rel);
  round_.notify_all();
  work(false);
  for (int left = left_.load(std::memory_order_acquire); left > 0;) {
    left = wait_while(left_, left);
  }
  for (const std::exception_ptr& failure : failures_) {
    if (failure) std::rethrow_exception(failure);
  }
}

void Workers::work(bool from_end) {
  int done = 0;
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  while (true) {
    const std::uint64_t tasks = ticket >> (2 * kTaskBits);
    const std::uint64_t front = ticket & kTaskMask;
    const std::uint64_t back = (ticket >> kTaskBits) & kTaskMask;
    if (front + back >= tasks) break;
    const std::uint64_t taken = ticket + (from_end ? std::uint64_t{1} << kTaskBits : 1);
    if (!ticket_.compare_exchange_weak(
            ticket, taken, std::memory_order_acq_rel, std::memory_order_acquire)) {
      continue;
    }
    // The caller waits for this task, so job_ stays what it is.
    const auto task = static_cast<int>(from_end ? tasks - 1 - back : front);
    try {
      (*job_)(task);
    } catch (...) {
      failures_[static_cast<std::size_t>(task)] = std::current_exception();
    }
    ++done;
    ticket = ticket_.load(std::memory_order_acquire);
  }
  if (done > 0 && left_.fetch_sub(done, std::memory_order_acq_rel) == done) {
    left_.notify_all();
  }
}

void Workers::serve() {
  int seen = 0;
  while (true) {
    seen = wait_while(round_, seen);
    if (stop_.load(std::memory_order_acquire)) return;
    work(true);
  }
}

}  // namespace sixdial::calibration
