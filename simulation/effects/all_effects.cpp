// The catalogue, in alphabetical order. Nothing may depend on the order.
#include <algorithm>
#include <array>

#include "simulation/effect.h"

namespace sixdial::simulation {

extern constinit const Effect base_drift, cuboid_offset, cuboid_size, cuboid_squareness,
    dial_cyclic, dial_gain, dial_hysteresis, dial_lean, dial_mount, dial_swap, frame_skew,
    joint_backlash, joint_compliance, joint_eccentricity, joint_gain, joint_second_harmonic,
    link_thermal_growth, passive_clearance, step, tip_radius;

namespace {
constexpr std::array kAll{
    &base_drift,
    &cuboid_offset,
    &cuboid_size,
    &cuboid_squareness,
    &dial_cyclic,
    &dial_gain,
    &dial_hysteresis,
    &dial_lean,
    &dial_mount,
    &dial_swap,
    &frame_skew,
    &joint_backlash,
    &joint_compliance,
    &joint_eccentricity,
    &joint_gain,
    &joint_second_harmonic,
    &link_thermal_growth,
    &passive_clearance,
    &step,
    &tip_radius};
}  // namespace

std::span<const Effect* const> all_effects() { return kAll; }

const Effect* find_effect(std::string_view cause) {
  const auto found = std::find_if(
      kAll.begin(), kAll.end(), [&](const Effect* effect) { return effect->cause == cause; });
  return found == kAll.end() ? nullptr : *found;
}

std::vector<Place> at_each_joint(const geometry::Rig&) {
  return {{.name = "joint1", .joint = 0}, {.name = "joint2", .joint = 1}};
}

std::vector<Place> at_each_dial(const geometry::Rig& rig) {
  std::vector<Place> result;
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    result.push_back({.name = rig.dials[i].id, .dial = static_cast<int>(i)});
  }
  return result;
}

std::vector<Place> at_each_pair_of_dials(const geometry::Rig& rig) {
  std::vector<Place> result;
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    for (std::size_t j = i + 1; j < rig.dials.size(); ++j) {
      result.push_back(
          {.name = rig.dials[i].id + "," + rig.dials[j].id,
           .dial = static_cast<int>(i),
           .other_dial = static_cast<int>(j)});
    }
  }
  return result;
}

std::vector<Place> at_one_place(std::string_view name) {
  return {Place{.name = std::string(name)}};
}

EffectParameter parameter_at(const Effect& effect, const Place& place, int k) {
  EffectParameter parameter = effect.parameters[static_cast<std::size_t>(k)];
  if (effect.cause != "step" || k > 1) return parameter;
  constexpr double kLever_mm = 60.0;
  if (place.joint >= 0 || place.name == "cuboid") {
    return {parameter.name, "rad", parameter.sigma / kLever_mm};
  }
  parameter.unit = "mm";
  return parameter;
}

}  // namespace sixdial::simulation
