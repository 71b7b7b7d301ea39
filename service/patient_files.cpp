#include "service/patient_files.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "service/service.h"

namespace sixdial::service {
namespace {

constexpr auto kLookForEnd = std::chrono::milliseconds(50);
constexpr int kMostHanging = 16;

struct Task {
  std::mutex mutex;
  std::condition_variable ended;
  bool over = false;
  std::exception_ptr thrown;
};

/// Threads that were given up and still hang in the kernel.
std::atomic<int>& hanging() {
  static std::atomic<int> count = 0;
  return count;
}

}  // namespace

void run_patiently(
    const Service& service, const std::filesystem::path& path, std::function<void()> work,
    std::chrono::milliseconds patience) {
  if (hanging() >= kMostHanging) {
    throw Error(
        ErrorCode::kFile,
        fmt::format(
            "{} is not tried: {} earlier requests still hang on files", path.string(),
            kMostHanging),
        {{"file", path.string()}},
        "See which share does not answer; starting the service again frees them.");
  }
  const auto task = std::make_shared<Task>();
  const auto given_up = std::make_shared<std::atomic<bool>>(false);
  std::thread([task, given_up, work = std::move(work)] {
    std::exception_ptr thrown;
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard lock(task->mutex);
    task->over = true;
    task->thrown = std::move(thrown);
    if (*given_up) --hanging();
    task->ended.notify_all();
  }).detach();
  const auto end = std::chrono::steady_clock::now() + patience;
  std::unique_lock lock(task->mutex);
  while (!task->ended.wait_for(lock, kLookForEnd, [&] { return task->over; })) {
    const bool late = std::chrono::steady_clock::now() >= end;
    if (!late && !service.stopping()) continue;
    *given_up = true;
    ++hanging();
    if (!late) throw Error(ErrorCode::kShuttingDown, "the service is going down");
    spdlog::warn("{} does not answer; the request is given up", path.string());
    throw Error(
        ErrorCode::kFile,
        fmt::format(
            "{} does not answer within {:.0f} s", path.string(),
            std::chrono::duration<double>(patience).count()),
        {{"file", path.string()}},
        "Is it a pipe that nobody writes into, or on a share that is gone?");
  }
  // Taken out, so that it ends with this thread, whichever thread gives up the task last.
  if (const auto thrown = std::exchange(task->thrown, nullptr)) std::rethrow_exception(thrown);
}

}  // namespace sixdial::service
