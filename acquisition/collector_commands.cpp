// The collector's commands from other threads, the pause they end, and what it tells.
#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "acquisition/collector.h"

namespace sixdial::acquisition {

std::string_view to_string(CollectorStage stage) {
  switch (stage) {
    case CollectorStage::kMoving:
      return "moving";
    case CollectorStage::kSettling:
      return "settling";
    case CollectorStage::kStored:
      return "stored";
    case CollectorStage::kSkipped:
      return "skipped";
    case CollectorStage::kFailed:
      return "failed";
    case CollectorStage::kPaused:
      return "paused";
    case CollectorStage::kFinished:
      return "finished";
    case CollectorStage::kStopped:
      return "stopped";
  }
  return "unknown";
}

std::string_view to_string(PauseReason reason) {
  switch (reason) {
    case PauseReason::kAsked:
      return "asked";
    case PauseReason::kDialFault:
      return "dial_fault";
    case PauseReason::kBranchChange:
      return "mode_change";
    case PauseReason::kRobot:
      return "robot";
    case PauseReason::kStore:
      return "store";
    case PauseReason::kFirstMove:
      return "first_move";
    case PauseReason::kLostContact:
      return "lost_contact";
  }
  return "unknown";
}

Collector::Wish Collector::wait_paused(
    std::optional<std::size_t> index, PauseReason reason, const std::string& trouble,
    const std::string& advice, const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    pause_wanted_ = true;
    paused_ = true;
    wish_ = Wish::kNone;
  }
  const DeviceTime start = clock_.monotonic();
  settling_.clear();
  if (callbacks_.progress) {
    CollectorProgress progress = progress_at(CollectorStage::kPaused, index);
    progress.message = advice.empty() ? trouble : trouble + "; " + advice;
    progress.pause = reason;
    progress.trouble = trouble;
    callbacks_.progress(progress);
  }
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return !pause_wanted_; });
  pause_wanted_ = false;
  paused_ = false;
  paused_for_ += clock_.monotonic() - start;
  return std::exchange(wish_, Wish::kNone);
}

Collector::Wish Collector::take_wish() {
  const std::lock_guard lock(mutex_);
  return std::exchange(wish_, Wish::kNone);
}

void Collector::wish(Wish wish) {
  std::optional<std::stop_source> here;
  {
    const std::lock_guard lock(mutex_);
    wish_ = wish;
    if (paused_) {
      pause_wanted_ = false;
    } else {
      here = here_;
    }
  }
  changed_.notify_all();
  if (here) here->request_stop();
}

void Collector::pause() {
  const std::lock_guard lock(mutex_);
  pause_wanted_ = true;
}

void Collector::resume() {
  {
    const std::lock_guard lock(mutex_);
    pause_wanted_ = false;
  }
  changed_.notify_all();
}

void Collector::skip() { wish(Wish::kSkip); }
void Collector::retake() { wish(Wish::kRetake); }

void Collector::retake(std::size_t plan_index) {
  if (plan_index >= plan_.points.size()) {
    throw std::invalid_argument(
        fmt::format("retake: point {} of a plan of {}", plan_index, plan_.points.size()));
  }
  {
    const std::lock_guard lock(mutex_);
    retakes_.push_back(plan_index);
    if (paused_) pause_wanted_ = false;
  }
  changed_.notify_all();
}

void Collector::accept() {
  const std::lock_guard lock(mutex_);
  if (!paused_) return;
  wish_ = Wish::kAccept;
  pause_wanted_ = false;
  changed_.notify_all();
}

CollectorProgress Collector::progress_at(
    CollectorStage stage, std::optional<std::size_t> index) const {
  CollectorProgress progress;
  progress.stage = stage;
  progress.done = done_;
  progress.total = plan_.points.size();
  progress.left_out = result_.left_out;
  progress.plan_index = index;
  progress.eta_s = eta_s();
  progress.settling = settling_;
  return progress;
}

void Collector::report(
    CollectorStage stage, std::optional<std::size_t> index, std::string message,
    std::vector<Reading> readings) {
  if (!callbacks_.progress) return;
  CollectorProgress progress = progress_at(stage, index);
  progress.message = std::move(message);
  progress.readings = std::move(readings);
  callbacks_.progress(progress);
}

std::optional<double> Collector::eta_s() const {
  if (result_.stored == 0) return std::nullopt;
  const DeviceTime worked = clock_.monotonic() - started_ - paused_for_;
  const double each = static_cast<double>(clock_.wall(worked).count()) * 1e-9 /
                      static_cast<double>(result_.stored);
  return each * static_cast<double>(plan_.points.size() - done_);
}

}  // namespace sixdial::acquisition
