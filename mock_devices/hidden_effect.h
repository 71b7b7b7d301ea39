// What is secretly wrong with one true rig: causes of hidden/, each as an id, a place and
// numbers. world.h applies them; nothing here knows how a diagnosis looks for them.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/rig.h"
#include "mock_devices/hidden/cause.h"

namespace sixdial::mock_devices {

struct HiddenEffect {
  std::string cause;                         // "joint_backlash"
  std::string where;                         // "joint2", "C", "C,D", "base", ...
  std::map<std::string, double> parameters;  // by name with unit: {"b_rad", 3e-4}
  friend bool operator==(const HiddenEffect&, const HiddenEffect&) = default;
};

[[nodiscard]] std::span<const CauseRow* const> causes();
/// Throws std::invalid_argument that lists the known causes.
[[nodiscard]] const CauseRow& cause_row(std::string_view id);

/// An effect of a given amplitude; what else it needs (phase, direction, period, the sample of
/// a step) is drawn from the seed. `samples`: expected length of the session. Throws
/// std::invalid_argument for an unknown cause or place.
[[nodiscard]] HiddenEffect make_effect(
    const geometry::Rig& rig, std::string_view cause, std::string_view where, double amplitude,
    std::uint64_t seed, int samples = 150);
/// "cause:where:amplitude", as in `--hide joint_backlash:joint2:0.0004`; without the amplitude,
/// or without place and amplitude, these are drawn.
[[nodiscard]] HiddenEffect parse_effect(
    const geometry::Rig& rig, std::string_view text, std::uint64_t seed, int samples = 150);

enum class Pool { kCatalogue, kOutside, kAll };
/// Cause, place and amplitude from a seed.
[[nodiscard]] HiddenEffect draw_effect(
    const geometry::Rig& rig, std::uint64_t seed, Pool pool = Pool::kCatalogue,
    int samples = 150);
/// One of a given cause, place and amplitude drawn.
[[nodiscard]] HiddenEffect draw_effect_of(
    const geometry::Rig& rig, std::string_view cause, std::uint64_t seed, int samples = 150);

/// The same effect so many times as large: what is a period, a phase or a sample stays.
[[nodiscard]] HiddenEffect enlarged(HiddenEffect effect, double times);

/// Its place as an index and its numbers in order. `q_reference`: joint angles at the cuboid's
/// reference pose. Throws std::invalid_argument if it makes no sense on this rig.
[[nodiscard]] ReadyEffect made_ready(
    const HiddenEffect& effect, const geometry::Rig& rig, const Eigen::Vector2d& q_reference);

}  // namespace sixdial::mock_devices
