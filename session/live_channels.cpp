#include "session/live_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "geometry/instrument_kind.h"

namespace sixdial::session {
namespace {

/// What a reading of 1 mm is on the channel.
struct LiveKind {
  std::string_view kind;     // of the instrument
  std::string_view channel;  // what stands before a place's name
  double per_reading = 1.0;
};
constexpr std::array kKinds{
    LiveKind{"distance", "distance_", 1.0}, LiveKind{"probe", "probe_", -1.0}};

const LiveKind* live_kind(const geometry::Rig& rig) {
  if (rig.dials.empty()) return nullptr;
  const auto* const found = std::ranges::find(kKinds, rig.instrument.kind, &LiveKind::kind);
  return found == kKinds.end() ? nullptr : found;
}

/// The channel of each dial among the instrument's; -1: it has none of that name.
std::vector<int> channels_of(const geometry::Rig& rig, const LiveKind& kind) {
  const auto instrument = geometry::instrument_of(rig);
  std::vector<int> channels;
  for (const geometry::Dial& dial : rig.dials) {
    channels.push_back(
        instrument->find_channel(fmt::format("{}{}", kind.channel, dial.id)).value_or(-1));
  }
  return channels;
}

}  // namespace

bool has_live_channels(const geometry::Rig& rig) { return live_kind(rig) != nullptr; }

std::optional<std::string> live_channel_fault(const geometry::Rig& rig) {
  const LiveKind* kind = live_kind(rig);
  if (kind == nullptr) return std::nullopt;
  const std::vector<int> channels = channels_of(rig, *kind);
  const char* const place = kind->kind == "probe" ? "surface" : "anchor";
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i] >= 0) continue;
    return fmt::format(
        "dial '{}' is the name of no [[{}]]: each dial reads the place of its name",
        rig.dials[i].id, place);
  }
  const auto instrument = geometry::instrument_of(rig);
  for (int c = 0; c < static_cast<int>(instrument->channels.size()); ++c) {
    if (std::ranges::find(channels, c) != channels.end()) continue;
    const std::string& name = instrument->channels[static_cast<std::size_t>(c)].name;
    return fmt::format("no [[dial]] reads {} '{}'", place, name.substr(kind->channel.size()));
  }
  return std::nullopt;
}

geometry::Rig as_instrument(geometry::Rig rig) {
  if (has_live_channels(rig)) rig.dials.clear();
  return rig;
}

Sample as_instrument(const geometry::Rig& rig, Sample sample) {
  const LiveKind* kind = live_kind(rig);
  if (kind == nullptr) return sample;
  const std::vector<int> channels = channels_of(rig, *kind);
  sample.others.assign(geometry::instrument_of(rig)->channels.size(), std::nullopt);
  for (std::size_t i = 0; i < channels.size() && i < sample.channels.size(); ++i) {
    const ChannelValue& reading = sample.channels[i];
    if (channels[i] < 0 || !reading.value || reading.quality == Quality::kBad) continue;
    sample.others[static_cast<std::size_t>(channels[i])] = kind->per_reading * *reading.value;
  }
  sample.channels.clear();
  return sample;
}

Sample as_dials(const geometry::Rig& rig, Sample sample) {
  const LiveKind* kind = live_kind(rig);
  if (kind == nullptr || sample.others.empty()) return sample;
  const std::vector<int> channels = channels_of(rig, *kind);
  sample.channels.assign(channels.size(), {.quality = Quality::kBad, .reason = "not read"});
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i] < 0 || static_cast<std::size_t>(channels[i]) >= sample.others.size())
      continue;
    const auto& shown = sample.others[static_cast<std::size_t>(channels[i])];
    if (shown) sample.channels[i] = {.value = *shown / kind->per_reading};
  }
  return sample;
}

Session as_instrument(Session session) {
  if (!has_live_channels(session.rig)) return session;
  for (Sample& sample : session.samples) {
    sample = as_instrument(session.rig, std::move(sample));
  }
  session.rig = as_instrument(std::move(session.rig));
  return session;
}

}  // namespace sixdial::session
