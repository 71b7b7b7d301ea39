#include "service/sample_json.h"

#include <fmt/format.h>

#include "service/or_null.h"
#include "session/live_channels.h"
#include "session/reason.h"
#include "session/sample_layout.h"
#include "session/trials.h"

namespace sixdial::service {
namespace {

template <typename Vector>
Json point_or_null(const std::optional<Vector>& point) {
  return point ? Json(std::vector<double>(point->begin(), point->end())) : Json(nullptr);
}

/// As its instrument sees it. A sample out of the store has been made so already.
simulation::Trial seen_trial(const geometry::Rig& rig, const session::Sample& sample) {
  return session::has_live_channels(rig)
             ? session::trial_of(
                   session::as_instrument(rig), session::as_instrument(rig, sample))
             : session::trial_of(rig, sample);
}

}  // namespace

std::string doubt_of(const geometry::Rig& rig, const session::Sample& sample) {
  std::string doubt;
  for (std::size_t i = 0; i < sample.channels.size() && i < rig.dials.size(); ++i) {
    const session::ChannelValue& value = sample.channels[i];
    if (value.quality == session::Quality::kGood || value.reason == session::reason::kNoContact)
      continue;
    doubt += fmt::format(
        "{}dial {}: {}", doubt.empty() ? "" : "; ", rig.dials[i].id,
        value.reason.empty() ? session::to_string(value.quality) : value.reason);
  }
  if (session::has_live_channels(rig)) {
    const bool none = session::has_live_positions(rig) && !seen_trial(rig, sample).position_mm;
    return none && doubt.empty()
               ? fmt::format("{} wires with known anchors are needed", session::kLeastWires)
               : doubt;
  }
  if (!rig.on_cuboid() || session::trial_of(rig, sample).position_mm) return doubt;
  return doubt.empty() ? "three dials that touch are needed" : "no position: " + doubt;
}

Json sample_json(const geometry::Rig& rig, const session::Sample& sample) {
  Json dials = Json::object();
  for (std::size_t i = 0; i < sample.channels.size() && i < rig.dials.size(); ++i) {
    const session::ChannelValue& value = sample.channels[i];
    Json row{
        {"value_mm", or_null(value.value)}, {"quality", session::to_string(value.quality)}};
    if (!value.reason.empty()) row["reason"] = value.reason;
    dials[rig.dials[i].id] = std::move(row);
  }
  const simulation::Trial trial = seen_trial(rig, sample);
  Json json{
      {"set", sample.set},
      {"point", sample.point},
      {"repeat", sample.repeat},
      {"time_utc",
       sample.time_utc ? Json(session::to_iso8601(*sample.time_utc)) : Json(nullptr)},
      {"target_mm", point_or_null(sample.target_mm)},
      {"approach", Json::array()},
      {"temperature_c", or_null(sample.temperature_c)},
      {"dials", std::move(dials)},
      {"readings_within_ms", or_null(session::readings_within_ms(sample))},
      {"position_mm", point_or_null(trial.position_mm)},
      {"gamma_rad", or_null(trial.gamma_rad)}};
  const session::SampleLayout layout = session::layout_of(rig);
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    json[layout.joints[i].column()] = sample.q[static_cast<Eigen::Index>(i)];
    json["approach"].push_back(or_null(session::approach_of(sample, i)));
  }
  return json;
}

}  // namespace sixdial::service
