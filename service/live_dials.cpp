#include "service/live_dials.h"

#include "session/reason.h"
#include "session/reason_words.h"
#include "session/trials.h"

namespace sixdial::service {
namespace {

/// What a sound dial may answer as long as its plunger is driven.
bool is_of_motion(std::string_view reason) {
  namespace why = session::reason;
  return reason == why::kNoDial || reason == why::kBusy || reason == why::kDevice ||
         reason == why::kTimeout;
}

DialState state_of(const acquisition::Reading& reading, bool moving, bool under_way) {
  if (reading.value_mm) return moving ? DialState::kSettling : DialState::kOk;
  if (reading.reason == session::reason::kNoContact) return DialState::kFree;
  if (under_way && is_of_motion(reading.reason)) return DialState::kWaiting;
  return reading.reason == session::reason::kStale ? DialState::kStale : DialState::kLost;
}

}  // namespace

std::string_view to_string(DialState state) {
  switch (state) {
    case DialState::kOk:
      return "ok";
    case DialState::kSettling:
      return "settling";
    case DialState::kWaiting:
      return "waiting";
    case DialState::kFree:
      return "free";
    case DialState::kStale:
      return "stale";
    case DialState::kLost:
      return "lost";
  }
  return "";
}

Json LiveDials::show(
    const std::vector<acquisition::Reading>& readings, const session::PlanPoint* point,
    const acquisition::CollectorProgress& now) const {
  const bool under_way = now.stage == acquisition::CollectorStage::kMoving;
  Json dials = Json::object();
  Json settle{
      {"spread_mm", nullptr}, {"limit_mm", nullptr}, {"settled", nullptr}, {"dial", nullptr}};
  double worst = -1.0;  // spread over its limit
  bool settled = true;
  for (std::size_t i = 0; i < readings.size() && i < rig_.dials.size(); ++i) {
    const acquisition::Reading& reading = readings[i];
    bool moving = under_way;
    if (i < now.settling.size()) {
      const acquisition::DialSettling& judged = now.settling[i];
      moving = !judged.settled;
      settled = settled && (judged.settled || !reading.value_mm);
      if (judged.spread_mm && *judged.spread_mm / judged.limit_mm > worst) {
        worst = *judged.spread_mm / judged.limit_mm;
        settle["spread_mm"] = *judged.spread_mm;
        settle["limit_mm"] = judged.limit_mm;
        settle["dial"] = rig_.dials[i].id;
      }
      settle["settled"] = settled;
    }
    Json row{
        {"value_mm", reading.value_mm ? Json(*reading.value_mm) : Json(nullptr)},
        {"quality", session::to_string(reading.quality)},
        {"reason", reading.reason},
        {"words", session::brief_words(reading.reason)},
        {"state", to_string(state_of(reading, moving, under_way))}};
    if (!reading.detail.empty()) row["detail"] = reading.detail;
    dials[rig_.dials[i].id] = std::move(row);
  }
  return {
      {"stage", acquisition::to_string(now.stage)},
      {"dials", std::move(dials)},
      {"settle", std::move(settle)},
      {"pose", pose(readings, point)}};
}

Json LiveDials::watched(const std::vector<acquisition::Reading>& readings) const {
  acquisition::CollectorProgress at_rest;
  at_rest.stage = acquisition::CollectorStage::kPaused;
  Json shown = show(readings, nullptr, at_rest);
  shown["stage"] = "watching";
  return shown;
}

Json LiveDials::pose(
    const std::vector<acquisition::Reading>& readings, const session::PlanPoint* point) const {
  if (point == nullptr) return nullptr;
  session::Sample sample;
  sample.q = point->q;
  sample.target_mm = point->target_mm;
  sample.channels.resize(rig_.dials.size());
  for (std::size_t i = 0; i < readings.size() && i < sample.channels.size(); ++i) {
    sample.channels[i].value = readings[i].value_mm;
    sample.channels[i].quality = readings[i].quality;
  }
  const simulation::Trial trial = session::trial_of(rig_, sample);
  if (!trial.position_mm || !trial.gamma_rad) return nullptr;
  Json used = Json::array();
  for (const int dial : trial.position_channels) {
    used.push_back(rig_.dials[static_cast<std::size_t>(dial)].id);
  }
  return {
      {"x_mm", trial.position_mm->x()},
      {"y_mm", trial.position_mm->y()},
      {"gamma_rad", *trial.gamma_rad},
      {"dials", std::move(used)}};
}

}  // namespace sixdial::service
