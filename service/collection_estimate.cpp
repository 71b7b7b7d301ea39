// What the samples of a collection say so far of the robot, where its instrument shows
// positions.
#include <fmt/format.h>

#include "geometry/long_work.h"
#include "service/collection_run.h"
#include "session/live_channels.h"

namespace sixdial::service {

bool Collection::take_in(Run& run, const session::Sample& sample) {
  bool told = false;
  try {
    const geometry::LongWork work(run.stop);
    told = run.estimate && run.estimate->add(sample);
  } catch (const geometry::WorkEnded&) {
    return false;  // the next collection begins with an estimate of all samples
  }
  const db::PointKey key{sample.set, sample.point, sample.repeat};
  const std::lock_guard lock(mutex_);
  unusual_.erase(key);
  if (told && run.estimate->last_unusual()) unusual_[key] = *run.estimate->last_times_usual();
  return told;
}

/// What earlier runs of the session have left in the store.
void Collection::take_in_stored(Run& run) {
  const std::vector<session::Sample> samples = store_.load_session(run.id).samples;
  try {
    const geometry::LongWork work(run.stop);
    if (run.estimate) run.estimate->see_rig(samples);
  } catch (const geometry::WorkEnded&) {
    return;
  }
  bool told = false;
  for (const session::Sample& sample : samples) told = take_in(run, sample) || told;
  if (told) show_estimate(run);
}

std::string Collection::unusual(const std::string& session, const db::PointKey& point) const {
  const std::lock_guard lock(mutex_);
  const auto found = unusual_.find(point);
  if (session != session_ || found == unusual_.end()) return "";
  return fmt::format("{:.0f} times as far off as usual", found->second);
}

void Collection::samples_changed(const std::string& session) {
  std::shared_ptr<const Run> run;
  std::uint64_t turn = 0;
  {
    const std::lock_guard lock(mutex_);
    if (session != session_ || is_active(state_) || !run_) return;
    run = run_;
    turn = ++estimate_turn_;
    unusual_.clear();
    estimate_.reset();
  }
  if (session::has_live_channels(run->rig) && !session::has_live_positions(run->rig)) return;
  studies::LiveEstimate estimate(run->seen_rig, run->plan.points);
  std::map<db::PointKey, double> unusual;
  bool told = false;
  const std::vector<session::Sample> samples = store_.load_session(run->id).samples;
  estimate.see_rig(samples);
  for (const session::Sample& sample : samples) {
    if (!estimate.add(sample)) continue;
    told = true;
    if (!estimate.last_unusual()) continue;
    unusual[{sample.set, sample.point, sample.repeat}] = *estimate.last_times_usual();
  }
  {
    const std::lock_guard lock(mutex_);
    // Another collection has begun meanwhile, or another sample was withdrawn.
    if (turn != estimate_turn_) return;
    unusual_ = std::move(unusual);
    if (told) estimate_ = estimate.summary();
  }
  publish("estimate");
}

void Collection::show_estimate(const Run& run) {
  studies::EstimateSummary estimate = run.estimate->summary();
  const std::lock_guard lock(mutex_);
  estimate_ = std::move(estimate);
}

}  // namespace sixdial::service
