// What is told of a collection between its samples: the dials as they are, a robot that is
// silent, a clock that was set.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "service/collection_run.h"
#include "service/live_dials.h"
#include "service/store_json.h"

namespace sixdial::service {
namespace {

constexpr auto kLiveEvery = std::chrono::milliseconds(200);  // on the wall
constexpr std::size_t kMostClockSteps = 20;

}  // namespace

// Stored times stay what the clock said; that it was changed is stored beside them.
void Collection::watch_clock(Run& run) {
  const auto step = run.clock_watch.look();
  if (!step) return;
  std::string told;
  {
    const std::lock_guard lock(mutex_);
    told = fmt::format(
        "{} after {} samples of this run: times before and after do not compare",
        acquisition::describe(*step), stored_);
    clock_remarks_.push_back(acquisition::describe(*step));
    if (clock_steps_.size() < kMostClockSteps) {
      clock_steps_.push_back(
          {{"by_s", std::chrono::duration<double>(step->by).count()},
           {"time_utc", session::to_iso8601(step->now)},
           {"after_samples", stored_}});
    }
  }
  spdlog::warn("{}", told);
  try {
    store_.record_action(to_operator(run.caller), kClockStep, run.id, told);
  } catch (const std::exception& trouble) {
    spdlog::error("a step of the clock is not in the store: {}", trouble.what());
  }
  publish("clock_step", {{"message", told}});
}

void Collection::publish_live(const std::stop_token& stop, Run& run) {
  std::mutex mutex;
  std::condition_variable_any over;
  std::unique_lock lock(mutex);
  const LiveDials shown(run.rig);
  while (!over.wait_for(lock, stop, kLiveEvery, [&] { return stop.stop_requested(); })) {
    acquisition::CollectorProgress now;
    {
      const std::lock_guard state_lock(mutex_);
      now = progress_;
    }
    Json data = shown.show(
        run.dials->latest(), now.plan_index ? &run.plan.points.at(*now.plan_index) : nullptr,
        now);
    data["type"] = "dials";
    data["session"] = session_;
    data["robot_silent_s"] =
        std::chrono::duration<double>(clock_.wall(run.robot->silent_for())).count();
    events_.publish(kLiveTopic, std::move(data));
    watch_clock(run);
  }
}

}  // namespace sixdial::service
