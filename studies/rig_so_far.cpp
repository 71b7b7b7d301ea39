#include "studies/rig_so_far.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/rig_spaces.h"
#include "session/trials.h"
#include "simulation/rig_quantities.h"
#include "studies/plausibility_of_fit.h"
#include "studies/seen_rig.h"

namespace sixdial::studies {
namespace {

constexpr std::size_t kFirst = 10;  // fewer poses than this are too few for any rig with dials
constexpr double kMore = 1.2;       // all fits together cost six times the last one

std::optional<diagnosis::RigFit> fitted(
    std::span<const session::Sample> samples, const geometry::Rig& file) {
  session::Session so_far;
  so_far.rig = file;
  so_far.samples.assign(samples.begin(), samples.end());
  PlausibleSession judged = plausible(so_far);
  // Frame or columns are the session's own: what the file says of its dials is not about them.
  if (judged.frame || !judged.dial_of_column.empty()) return std::nullopt;
  for (std::size_t i = 0; i < so_far.samples.size(); ++i) {
    // The filter takes joint values as they were read.
    if (judged.session.samples[i].q != so_far.samples[i].q) return std::nullopt;
  }
  const auto g1 = session::trials_of(judged.session, "G1");
  add_too_few_poses(judged.warnings, g1, file, {}, {});
  if (why_no_reading_is_judged(judged.warnings)) return std::nullopt;
  return diagnosis::fit_rig(g1, file);
}

}  // namespace

RigSoFar::RigSoFar(const geometry::Rig& file)
    : file_(file),
      states_(!file.dials.empty() && !simulation::stated_quantities(file).empty()),
      next_(kFirst) {}

void RigSoFar::add(const session::Sample& sample) {
  if (!states_ || sample.set != "G1") return;
  std::erase_if(samples_, [&](const session::Sample& each) {
    return each.point == sample.point && each.repeat == sample.repeat;
  });
  samples_.push_back(sample);
}

bool RigSoFar::is_due() const { return states_ && samples_.size() >= next_; }

bool RigSoFar::fit() { return fit(samples_); }

bool RigSoFar::fit(std::span<const session::Sample> samples) {
  if (!states_) return false;
  auto seen = fitted(samples, file_);
  const auto count = std::ranges::count(samples, "G1", &session::Sample::set);
  next_ = std::max(kFirst, static_cast<std::size_t>(kMore * static_cast<double>(count)) + 1);
  const bool changed = seen || seen_;
  seen_ = std::move(seen);
  if (seen_) open_root_ = root_of_open(*seen_);
  return changed;
}

std::vector<RigSoFar::Measured> RigSoFar::measured(
    std::span<const session::Sample> samples) const {
  std::vector<simulation::Trial> trials;
  for (const session::Sample& each : samples) {
    trials.push_back(session::trial_of(rig(), each, static_cast<int>(trials.size())));
  }
  std::vector<Measured> result;
  for (const simulation::Trial& each : trials) result.push_back({each});
  if (!states_) return result;
  calibration::ObservationSpace space = calibration::position_space(trials, rig());
  if (seen_) space = with_rig_as_seen(std::move(space), trials, *seen_, open_root_);
  for (int i = 0; i < space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    result[static_cast<std::size_t>(space.sample[k])].shared =
        space.rig_mm.middleRows(space.first_row[k], space.rows(i));
  }
  return result;
}

}  // namespace sixdial::studies
