#include "geometry/instrument_kind.h"

#include <algorithm>
#include <deque>
#include <stdexcept>

#include "geometry/instruments/dials_on_cuboid.h"
#include "geometry/instruments/distance.h"
#include "geometry/instruments/pose.h"
#include "geometry/instruments/position.h"
#include "geometry/instruments/probe.h"
#include "geometry/instruments/socket.h"
#include "geometry/rig.h"

namespace sixdial::geometry {
namespace {

/// One line for each kind that this program is built with.
std::vector<const InstrumentKind*>& rows() {
  static std::vector<const InstrumentKind*> all{&dials_on_cuboid, &position, &pose_of_tool,
                                                &distance,        &probe,    &socket};
  return all;
}

}  // namespace

std::optional<int> InstrumentModel::find_channel(std::string_view name) const {
  const auto found = std::ranges::find(channels, name, &ChannelInfo::name);
  if (found == channels.end()) return std::nullopt;
  return static_cast<int>(found - channels.begin());
}

std::span<const InstrumentKind* const> instrument_kinds() { return rows(); }

const InstrumentKind* find_instrument_kind(std::string_view name) {
  const auto found = std::ranges::find(rows(), name, &InstrumentKind::name);
  return found == rows().end() ? nullptr : *found;
}

const InstrumentKind& add_instrument_kind(InstrumentKind kind) {
  static std::deque<InstrumentKind> added;  // a deque: its elements stay where they are
  const std::string name(kind.name);
  if (name.empty() || kind.in_words.empty()) {
    throw std::invalid_argument("an instrument kind needs a name, also in words");
  }
  if (find_instrument_kind(name) != nullptr) {
    throw std::invalid_argument("there is an instrument kind '" + name + "' already");
  }
  if (!kind.of_rig || !kind.observe) {
    throw std::invalid_argument("instrument kind '" + name + "' lacks of_rig or observe");
  }
  added.push_back(kind);
  rows().push_back(&added.back());
  return added.back();
}

std::shared_ptr<const InstrumentModel> instrument_of(const Rig& rig) {
  const InstrumentKind* kind = find_instrument_kind(rig.instrument.kind);
  if (kind == nullptr) {
    throw std::invalid_argument(
        "rig '" + rig.name + "': there is no instrument '" + rig.instrument.kind + "'");
  }
  auto made = kind->of_rig(rig);
  if (!made) throw std::invalid_argument("rig '" + rig.name + "': " + made.error());
  return *std::move(made);
}

}  // namespace sixdial::geometry
