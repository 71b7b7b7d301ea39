// What can secretly be wrong with the true rig: the causes of spec 4 and several outside that
// catalogue, each as an id, a place and numbers. world.h applies them; nothing here knows how a
// diagnosis looks for them.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/rig.h"

namespace sixdial::mock_devices {

struct HiddenEffect {
  std::string cause;                         // "joint_backlash"
  std::string where;                         // "joint2", "C", "C,D", "base", ...
  std::map<std::string, double> parameters;  // by name with unit: {"b_rad", 3e-4}
  friend bool operator==(const HiddenEffect&, const HiddenEffect&) = default;
};

enum class Cause {
  kJointEccentricity,
  kJointSecondHarmonic,
  kJointGain,
  kJointBacklash,
  kJointCompliance,
  kLinkThermalGrowth,
  kPassiveClearance,
  kBaseDrift,
  kFrameSkew,
  kCuboidSize,
  kCuboidSquareness,
  kCuboidOffset,
  kTipRadius,
  kDialGain,
  kDialLean,
  kDialMount,
  kDialHysteresis,
  kDialCyclic,
  kDialSwap,
  kStep,
  kOutliers,
  kStaleReading,
  // outside the catalogue
  kXyField,
  kRandomWalk,
  kTimeSinusoid,
  kJointFifthHarmonic,
  kCreep,     // of an angle or a length, levelling off
  kDialBend,  // of a dial's scale
};

/// What the places of a cause are.
enum class PlaceKind {
  kJoint,
  kJoints,
  kLinks,
  kElbows,
  kBase,
  kFrame,
  kCuboid,
  kDials,
  kDial,
  kDialPair,
  kStep,
  kSamples,
  kTool,
  kArm,
};

struct CauseInfo {
  Cause cause;
  std::string_view id;
  PlaceKind places;
  bool in_catalogue;
  bool both_signs;
  /// Range of the amplitude for drawing, log-uniform, in the unit of the first parameter.
  double least, most;
  std::string_view amplitude;  // what the amplitude is, with unit
};
[[nodiscard]] std::span<const CauseInfo> causes();
/// Throws std::invalid_argument that lists the known causes.
[[nodiscard]] const CauseInfo& cause_info(std::string_view id);
/// All places of a cause on this rig, e.g. "joint1", "joint2".
[[nodiscard]] std::vector<std::string> places_of(
    const CauseInfo& info, const geometry::Rig& rig);

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

}  // namespace sixdial::mock_devices
