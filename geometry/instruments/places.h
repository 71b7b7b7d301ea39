// Points that an instrument refers to (anchors, sockets, points on the tool): exactly known, or
// three parameters each.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/instrument_kind.h"
#include "geometry/rig.h"

namespace sixdial::geometry {

/// Where a place stands among the instrument's parameters.
struct PlaceAt {
  Eigen::Vector3d known_mm{0, 0, 0};
  int first = -1;  // of its three parameters; -1: exactly known
  [[nodiscard]] Eigen::Vector3d at(std::span<const double> x) const {
    if (first < 0) return known_mm;
    const auto i = static_cast<std::size_t>(first);
    return {x[i], x[i + 1], x[i + 2]};
  }
};

/// Adds one parameter to an instrument; `known_to` +inf: not known. Returns its index.
int add_parameter(InstrumentModel& model, ParameterInfo info, double nominal, double known_to);

/// Adds the place's three parameters if it is not exactly known. `meaning`: "anchor K1".
[[nodiscard]] PlaceAt add_place(
    InstrumentModel& model, const ReferencePoint& place, const std::string& meaning);

/// Why a list of places cannot be used: an empty or a repeated name.
[[nodiscard]] std::optional<std::string> fault_of(
    std::span<const ReferencePoint> places, const char* what);

/// Sizes an observation; all derivatives are zero.
void clear(const InstrumentModel& model, std::size_t frames, bool say_shown, Observation& out);

/// What a channel reads where nothing of its own is told: the rig's deviation.
[[nodiscard]] double sd_of(const Rig& rig);

}  // namespace sixdial::geometry
