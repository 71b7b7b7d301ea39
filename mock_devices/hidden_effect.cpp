#include "mock_devices/hidden_effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using enum Cause;
constexpr double kTwoPi = 2 * std::numbers::pi;

// Ranges give visible ratios from about 0.1 to 5 on 150 default poses with 0.002 mm noise.
constexpr std::array kCauses{
    CauseInfo{
        kJointEccentricity, "joint_eccentricity", PlaceKind::kJoint, true, false, 8e-4, 8e-3,
        "amplitude [rad]"},
    CauseInfo{
        kJointSecondHarmonic, "joint_second_harmonic", PlaceKind::kJoint, true, false, 6e-5,
        1e-3, "amplitude [rad]"},
    CauseInfo{kJointGain, "joint_gain", PlaceKind::kJoint, true, true, 2e-4, 4e-3, "gain [1]"},
    CauseInfo{
        kJointBacklash, "joint_backlash", PlaceKind::kJoint, true, false, 2e-5, 4e-4,
        "width [rad]"},
    CauseInfo{
        kJointCompliance, "joint_compliance", PlaceKind::kJoints, true, false, 3e-7, 3e-6,
        "compliance [rad/(N mm)]"},
    CauseInfo{
        kLinkThermalGrowth, "link_thermal_growth", PlaceKind::kLinks, true, false, 5e-6, 4e-5,
        "expansion [1/K]"},
    CauseInfo{
        kPassiveClearance, "passive_clearance", PlaceKind::kElbows, true, false, 5e-4, 1e-2,
        "shift along the direction of travel [mm]"},
    CauseInfo{
        kBaseDrift, "base_drift", PlaceKind::kBase, true, false, 1e-2, 3e-1, "speed [mm/h]"},
    CauseInfo{
        kFrameSkew, "frame_skew", PlaceKind::kFrame, true, true, 5e-5, 1e-3, "angle [rad]"},
    CauseInfo{
        kCuboidSize, "cuboid_size", PlaceKind::kCuboid, true, true, 1e-3, 3e-2,
        "change of side [mm]"},
    CauseInfo{
        kCuboidSquareness, "cuboid_squareness", PlaceKind::kCuboid, true, true, 5e-5, 6e-4,
        "angle [rad]"},
    CauseInfo{
        kCuboidOffset, "cuboid_offset", PlaceKind::kCuboid, true, false, 2e-2, 5e-1,
        "distance from E [mm]"},
    CauseInfo{
        kTipRadius, "tip_radius", PlaceKind::kDials, true, true, 2e-2, 2e-1,
        "change of radius [mm]"},
    CauseInfo{kDialGain, "dial_gain", PlaceKind::kDial, true, true, 1e-4, 2e-3, "gain [1]"},
    CauseInfo{kDialLean, "dial_lean", PlaceKind::kDial, true, true, 8e-4, 1e-2, "angle [rad]"},
    CauseInfo{
        kDialMount, "dial_mount", PlaceKind::kDial, true, true, 2e-3, 5e-2,
        "shift along the axis [mm]"},
    CauseInfo{
        kDialHysteresis, "dial_hysteresis", PlaceKind::kDial, true, false, 1.5e-3, 1.2e-2,
        "width [mm]"},
    CauseInfo{
        kDialCyclic, "dial_cyclic", PlaceKind::kDial, true, false, 1e-3, 6e-3,
        "amplitude [mm]"},
    CauseInfo{kDialSwap, "dial_swap", PlaceKind::kDialPair, true, false, 1.0, 1.0, "none"},
    CauseInfo{
        kStep, "step", PlaceKind::kStep, true, true, 2e-3, 4e-2,
        "shift [mm] of a dial or the base, turn [rad] of a joint or the cuboid"},
    CauseInfo{
        kOutliers, "outliers", PlaceKind::kSamples, true, false, 5e-2, 5e-1,
        "largest error [mm]"},
    CauseInfo{
        kStaleReading, "stale_reading", PlaceKind::kSamples, true, false, 1e-2, 6e-2,
        "share of samples [1]"},
    CauseInfo{kXyField, "xy_field", PlaceKind::kTool, false, false, 1e-3, 2e-2, "rms [mm]"},
    CauseInfo{
        kRandomWalk, "random_walk", PlaceKind::kTool, false, false, 5e-3, 1e-1,
        "standard deviation after an hour [mm]"},
    CauseInfo{
        kTimeSinusoid, "time_sinusoid", PlaceKind::kTool, false, false, 1e-3, 2e-2,
        "amplitude [mm]"},
    CauseInfo{
        kJointFifthHarmonic, "joint_fifth_harmonic", PlaceKind::kJoint, false, false, 2e-5,
        3e-4, "amplitude [rad]"},
    CauseInfo{
        kCreep, "creep", PlaceKind::kArm, false, true, 2e-3, 4e-2,
        "change in the end [mm] of a link, turn [rad] of a joint"},
    CauseInfo{
        kDialBend, "dial_bend", PlaceKind::kDial, false, true, 1e-3, 1e-2,
        "error 10 mm away from the middle [mm]"},
};

bool is_angle_step(std::string_view where) {
  return where == "joint1" || where == "joint2" || where == "cuboid";
}

std::pair<double, double> amplitude_range(const CauseInfo& info, std::string_view where) {
  const bool shift = info.cause == kStep || info.cause == kCreep;
  if (!shift || !is_angle_step(where)) return {info.least, info.most};
  constexpr double kLeverPerMm = 1.0 / 60.0;  // a turn that moves the tool by about 1 mm
  return {info.least * kLeverPerMm, info.most * kLeverPerMm};
}

double drawn_amplitude(const CauseInfo& info, std::string_view where, const Random& random) {
  const auto [least, most] = amplitude_range(info, where);
  const double size = least * std::pow(most / least, random.uniform(10));
  return info.both_signs && random.uniform(11) < 0.5 ? -size : size;
}

template <std::size_t n>
double one_of(const std::array<double, n>& values, double uniform) {
  return values[static_cast<std::size_t>(uniform * static_cast<double>(n))];
}

}  // namespace

std::span<const CauseInfo> causes() { return kCauses; }

const CauseInfo& cause_info(std::string_view id) {
  const auto found = std::ranges::find(kCauses, id, &CauseInfo::id);
  if (found != kCauses.end()) return *found;
  std::string known;
  for (const CauseInfo& info : kCauses) known += fmt::format(" {}", info.id);
  throw std::invalid_argument(fmt::format("no cause '{}'; known are:{}", id, known));
}

std::vector<std::string> places_of(const CauseInfo& info, const geometry::Rig& rig) {
  std::vector<std::string> dials;
  for (const geometry::Dial& dial : rig.dials) dials.push_back(dial.id);
  switch (info.places) {
    case PlaceKind::kJoint:
      return {"joint1", "joint2"};
    case PlaceKind::kJoints:
      return {"joints"};
    case PlaceKind::kLinks:
      return {"links"};
    case PlaceKind::kElbows:
      return {"elbows"};
    case PlaceKind::kBase:
      return {"base"};
    case PlaceKind::kFrame:
      return {"frame"};
    case PlaceKind::kCuboid:
      return {"cuboid"};
    case PlaceKind::kDials:
      return {"dials"};
    case PlaceKind::kDial:
      return dials;
    case PlaceKind::kDialPair: {
      std::vector<std::string> pairs;
      for (std::size_t i = 0; i < dials.size(); ++i) {
        for (std::size_t j = i + 1; j < dials.size(); ++j) {
          pairs.push_back(dials[i] + "," + dials[j]);
        }
      }
      return pairs;
    }
    case PlaceKind::kStep:
      dials.insert(dials.begin(), {"base", "joint1", "joint2", "cuboid"});
      return dials;
    case PlaceKind::kSamples:
      return {"samples"};
    case PlaceKind::kTool:
      return {"tool"};
    case PlaceKind::kArm:
      return {"joint1", "joint2", "l11", "l12", "l21", "l22"};
  }
  return {};
}

HiddenEffect make_effect(
    const geometry::Rig& rig, std::string_view cause, std::string_view where, double amplitude,
    std::uint64_t seed, int samples) {
  const CauseInfo& info = cause_info(cause);
  const std::vector<std::string> places = places_of(info, rig);
  if (std::ranges::find(places, where) == places.end()) {
    std::string known;
    for (const std::string& place : places) known += " " + place;
    throw std::invalid_argument(fmt::format(
        "{} cannot be at '{}' on this rig; its places are:{}", cause, where, known));
  }
  if (!std::isfinite(amplitude)) {
    throw std::invalid_argument(fmt::format("{} at {}: amplitude is not finite", cause, where));
  }
  const Random random(seed, Stream::kHide);
  const double phase = random.uniform(20, 0.0, kTwoPi);
  const double c = std::cos(phase);
  const double s = std::sin(phase);
  HiddenEffect effect{std::string(cause), std::string(where), {}};
  auto& p = effect.parameters;
  switch (info.cause) {
    case kJointEccentricity:
    case kJointSecondHarmonic:
    case kJointFifthHarmonic:
      p = {{"a_rad", amplitude * c}, {"b_rad", amplitude * s}};
      break;
    case kJointGain:
      p = {{"gain", amplitude}};
      break;
    case kJointBacklash:
      p = {{"b_rad", amplitude}};
      break;
    case kJointCompliance:
      if (amplitude <= 0.0) throw std::invalid_argument("joint_compliance must be positive");
      p = {
          {"k1_nmm_per_rad", 1.0 / amplitude},
          {"k2_nmm_per_rad", random.uniform(21, 0.5, 2.0) / amplitude}};
      break;
    case kLinkThermalGrowth:
      p = {{"per_k", amplitude}};
      break;
    case kPassiveClearance:
      p = {{"c_mm", amplitude}};
      break;
    case kBaseDrift:
      p = {{"x_mm_per_h", amplitude * c}, {"y_mm_per_h", amplitude * s}};
      break;
    case kFrameSkew:
    case kCuboidSquareness:
    case kDialLean:
      p = {{"angle_rad", amplitude}};
      break;
    case kCuboidSize:
    case kTipRadius:
    case kDialMount:
      p = {{"change_mm", amplitude}};
      break;
    case kCuboidOffset:
      p = {{"x_mm", amplitude * c}, {"y_mm", amplitude * s}};
      break;
    case kDialGain:
      p = {{"gain", amplitude}};
      break;
    case kDialHysteresis:
      p = {{"width_mm", amplitude}};
      break;
    case kDialCyclic:
      p = {
          {"amplitude_mm", amplitude},
          {"period_mm", 1.0 * std::pow(12.0, random.uniform(22))},
          {"phase_rad", phase}};
      break;
    case kDialSwap:
      break;
    case kStep:
      p = {
          {"from_sample", std::floor(samples * random.uniform(23, 0.25, 0.75))},
          {is_angle_step(where) ? "amount_rad" : "amount_mm", amplitude}};
      if (where == "base") p["direction_rad"] = phase;
      break;
    case kOutliers:
      p = {
          {"share", random.uniform(24, 0.02, 0.05)},
          {"size_mm", std::abs(amplitude)},
          {"seed", std::floor(random.uniform(25, 0.0, 1e9))}};
      break;
    case kStaleReading:
      p = {
          {"share", std::abs(amplitude)},
          {"whole_scan", random.uniform(26) < 0.5 ? 1.0 : 0.0},
          {"seed", std::floor(random.uniform(25, 0.0, 1e9))}};
      break;
    case kXyField:
      p = {
          {"rms_mm", amplitude},
          {"length_mm", one_of(std::array{60.0, 25.0}, random.uniform(27))},
          {"seed", std::floor(random.uniform(25, 0.0, 1e9))}};
      break;
    case kRandomWalk:
      p = {{"mm_per_sqrt_h", amplitude}, {"seed", std::floor(random.uniform(25, 0.0, 1e9))}};
      break;
    case kTimeSinusoid:
      p = {
          {"amplitude_mm", amplitude},
          {"period_s", 200.0 * std::pow(10.0, random.uniform(22))},
          {"phase_rad", random.uniform(28, 0.0, kTwoPi)},
          {"direction_rad", phase}};
      break;
    case kCreep:
      p = {
          {is_angle_step(where) ? "amount_rad" : "amount_mm", amplitude},
          {"period_s", 300.0 * std::pow(20.0, random.uniform(22))}};
      break;
    case kDialBend:
      p = {{"bend_mm", amplitude}};
      break;
  }
  return effect;
}

HiddenEffect parse_effect(
    const geometry::Rig& rig, std::string_view text, std::uint64_t seed, int samples) {
  const std::size_t first = text.find(':');
  const std::string_view cause = text.substr(0, first);
  if (first == std::string_view::npos) return draw_effect_of(rig, cause, seed, samples);
  const std::string_view rest = text.substr(first + 1);
  const std::size_t second = rest.find(':');
  const std::string_view where = rest.substr(0, second);
  if (second == std::string_view::npos) {
    const double amplitude =
        drawn_amplitude(cause_info(cause), where, Random(seed, Stream::kHide));
    return make_effect(rig, cause, where, amplitude, seed, samples);
  }
  const std::string_view number = rest.substr(second + 1);
  double amplitude = 0.0;
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), amplitude);
  if (error != std::errc{} || end != number.data() + number.size()) {
    throw std::invalid_argument(fmt::format(
        "'{}': the amplitude '{}' is not a number; write cause:where:amplitude", text, number));
  }
  return make_effect(rig, cause, where, amplitude, seed, samples);
}

HiddenEffect draw_effect_of(
    const geometry::Rig& rig, std::string_view cause, std::uint64_t seed, int samples) {
  const CauseInfo& info = cause_info(cause);
  const Random random(seed, Stream::kHide);
  const std::vector<std::string> places = places_of(info, rig);
  if (places.empty()) {
    throw std::invalid_argument(fmt::format("{}: this rig has no place for it", cause));
  }
  const auto pick =
      static_cast<std::size_t>(random.uniform(1) * static_cast<double>(places.size()));
  const std::string& where = places[pick];
  return make_effect(rig, info.id, where, drawn_amplitude(info, where, random), seed, samples);
}

HiddenEffect draw_effect(const geometry::Rig& rig, std::uint64_t seed, Pool pool, int samples) {
  std::vector<const CauseInfo*> choice;
  for (const CauseInfo& info : kCauses) {
    if (pool == Pool::kAll || info.in_catalogue == (pool == Pool::kCatalogue)) {
      choice.push_back(&info);
    }
  }
  const double pick = Random(seed, Stream::kHide).uniform(0);
  const auto index = static_cast<std::size_t>(pick * static_cast<double>(choice.size()));
  return draw_effect_of(rig, choice[index]->id, seed, samples);
}

}  // namespace sixdial::mock_devices
