#include "geometry/instruments/places.h"

#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "geometry/robots/parameter_row.h"

namespace sixdial::geometry {

int add_parameter(InstrumentModel& model, ParameterInfo info, double nominal, double known_to) {
  const Eigen::Index n = model.parameter_count();
  info.rig_key.clear();
  model.parameters.push_back(std::move(info));
  model.nominal.conservativeResize(n + 1);
  model.nominal[n] = nominal;
  model.known_to.conservativeResize(n + 1);
  model.known_to[n] = known_to;
  return static_cast<int>(n);
}

PlaceAt add_place(
    InstrumentModel& model, const ReferencePoint& place, const std::string& meaning) {
  PlaceAt at;
  at.known_mm = place.at_mm.value_or(Eigen::Vector3d::Zero());
  if (place.at_mm && place.sd_mm == 0.0) return at;
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const int index = add_parameter(
        model, length_row(place.name + '_' + kAxes[i], meaning + ", along " + kAxes[i]),
        at.known_mm[static_cast<Eigen::Index>(i)], place.at_mm ? place.sd_mm : HUGE_VAL);
    if (i == 0) at.first = index;
  }
  return at;
}

std::optional<std::string> fault_of(std::span<const ReferencePoint> places, const char* what) {
  std::set<std::string> names;
  for (const ReferencePoint& place : places) {
    if (place.name.empty()) return std::string(what) + " needs a name";
    if (!names.insert(place.name).second) {
      return std::string(what) + " '" + place.name + "' appears twice";
    }
  }
  return std::nullopt;
}

void clear(const InstrumentModel& model, std::size_t frames, bool say_shown, Observation& out) {
  const Eigen::Index channels = model.channel_count();
  out.reading.setZero(channels);
  out.by_frames.setZero(channels, 6 * static_cast<Eigen::Index>(frames));
  out.by_x.setZero(channels, model.parameter_count());
  out.by_unknowns.resize(channels, 0);
  if (say_shown) out.shows.assign(static_cast<std::size_t>(channels), true);
}

double sd_of(const Rig& rig) { return rig.instrument.sd_mm; }

}  // namespace sixdial::geometry
