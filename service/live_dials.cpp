#include "service/live_dials.h"

#include <algorithm>

#include "session/trials.h"

namespace sixdial::service {
namespace {

// Values that must agree: shown every 0.2 s, so over longer than the collector's window.
constexpr std::size_t kLast = 2;
constexpr double kTimesRepeatability = 6.0;      // likewise
constexpr double kLeastSettleSpread_mm = 0.005;  // likewise

DialState state_of(const acquisition::Reading& reading, bool moving) {
  if (reading.value_mm) return moving ? DialState::kSettling : DialState::kOk;
  if (reading.reason == "no contact") return DialState::kFree;
  return reading.reason == "stale" ? DialState::kStale : DialState::kLost;
}

}  // namespace

std::string_view to_string(DialState state) {
  switch (state) {
    case DialState::kOk:
      return "ok";
    case DialState::kSettling:
      return "settling";
    case DialState::kFree:
      return "free";
    case DialState::kStale:
      return "stale";
    case DialState::kLost:
      return "lost";
  }
  return "";
}

LiveDials::LiveDials(const geometry::Rig& rig, double settle_spread_mm)
    : rig_(rig), settle_spread_mm_(settle_spread_mm), recent_(rig.dials.size()) {}

double LiveDials::limit_mm(std::size_t dial) const {
  if (settle_spread_mm_ > 0.0) return settle_spread_mm_;
  return std::max(
      kTimesRepeatability * rig_.dials[dial].repeatability_mm, kLeastSettleSpread_mm);
}

Json LiveDials::show(
    const std::vector<acquisition::Reading>& readings, const session::PlanPoint* point) {
  Json dials = Json::object();
  Json settle{{"spread_mm", nullptr}, {"limit_mm", nullptr}, {"settled", nullptr}};
  double worst = -1.0;  // spread over its limit
  bool settled = true;
  for (std::size_t i = 0; i < readings.size() && i < rig_.dials.size(); ++i) {
    const acquisition::Reading& reading = readings[i];
    Recent& recent = recent_[i];
    if (!reading.value_mm) recent.values_mm.clear();
    if (reading.value_mm && reading.sequence != recent.sequence) {
      recent.values_mm.push_back(*reading.value_mm);
      if (recent.values_mm.size() > kLast) recent.values_mm.pop_front();
    }
    recent.sequence = reading.sequence;
    bool moving = false;
    if (!recent.values_mm.empty()) {
      const auto [low, high] = std::ranges::minmax(recent.values_mm);
      moving = recent.values_mm.size() < kLast || high - low > limit_mm(i);
      const double times = (high - low) / limit_mm(i);
      settled = settled && !moving;
      if (times > worst) {
        worst = times;
        settle["spread_mm"] = high - low;
        settle["limit_mm"] = limit_mm(i);
      }
      settle["settled"] = settled;
    }
    Json row{
        {"value_mm", reading.value_mm ? Json(*reading.value_mm) : Json(nullptr)},
        {"quality", session::to_string(reading.quality)},
        {"reason", reading.reason},
        {"state", to_string(state_of(reading, moving))}};
    if (!reading.detail.empty()) row["detail"] = reading.detail;
    dials[rig_.dials[i].id] = std::move(row);
  }
  return {
      {"dials", std::move(dials)},
      {"settle", std::move(settle)},
      {"pose", pose(readings, point)}};
}

Json LiveDials::pose(
    const std::vector<acquisition::Reading>& readings, const session::PlanPoint* point) const {
  if (point == nullptr) return nullptr;
  session::Sample sample;
  sample.q_rad = point->q_rad;
  sample.target_mm = point->target_mm;
  sample.dials.resize(rig_.dials.size());
  for (std::size_t i = 0; i < readings.size() && i < sample.dials.size(); ++i) {
    sample.dials[i].value_mm = readings[i].value_mm;
    sample.dials[i].quality = readings[i].quality;
  }
  const simulation::Trial trial = session::trial_of(rig_, sample);
  if (!trial.position_mm || !trial.gamma_rad) return nullptr;
  Json used = Json::array();
  for (const int dial : trial.active_dials) {
    if (dial >= 0) used.push_back(rig_.dials[static_cast<std::size_t>(dial)].id);
  }
  return {
      {"x_mm", trial.position_mm->x()},
      {"y_mm", trial.position_mm->y()},
      {"gamma_rad", *trial.gamma_rad},
      {"dials", std::move(used)}};
}

}  // namespace sixdial::service
