#include "diagnosis/covariate.h"

#include <array>
#include <charconv>
#include <utility>

namespace sixdial::diagnosis {
namespace {

constexpr std::string_view kJoint = "theta";
constexpr std::string_view kApproach = "approach";
constexpr std::string_view kWeight = "weight";
constexpr std::string_view kDial = "dial ";
constexpr std::string_view kReading = " reading";
constexpr std::array kPlain{
    std::pair{DependsOn::kToolX, std::string_view("x")},
    std::pair{DependsOn::kToolY, std::string_view("y")},
    std::pair{DependsOn::kToolZ, std::string_view("z")},
    std::pair{DependsOn::kCuboidAngle, std::string_view("gamma")},
    std::pair{DependsOn::kTime, std::string_view("time")},
    std::pair{DependsOn::kTemperature, std::string_view("temperature")}};

/// 1 of "approach2"; empty: another name.
std::optional<int> joint_of(std::string_view prefix, std::string_view name) {
  if (!name.starts_with(prefix)) return std::nullopt;
  name.remove_prefix(prefix.size());
  int number = 0;
  const auto [end, trouble] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (trouble != std::errc() || end != name.data() + name.size() || number < 1) {
    return std::nullopt;
  }
  return number - 1;
}

}  // namespace

std::string dependence_name(const DependsOnWhat& what) {
  switch (what.on) {
    case DependsOn::kJointAngle:
      return std::string(kJoint) + std::to_string(what.joint + 1);
    case DependsOn::kApproach:
      return std::string(kApproach) + std::to_string(what.joint + 1);
    case DependsOn::kWeight:
      return std::string(kWeight) + std::to_string(what.joint + 1);
    case DependsOn::kReading:
      return std::string(kDial) + what.dial + std::string(kReading);
    default:
      break;
  }
  for (const auto& [on, name] : kPlain) {
    if (on == what.on) return std::string(name);
  }
  return {};
}

std::optional<DependsOnWhat> dependence_from(std::string_view name) {
  for (const auto& [on, plain] : kPlain) {
    if (plain == name) return DependsOnWhat{.on = on};
  }
  for (const auto& [on, prefix] :
       {std::pair{DependsOn::kJointAngle, kJoint},
        {DependsOn::kApproach, kApproach},
        {DependsOn::kWeight, kWeight}}) {
    if (const auto joint = joint_of(prefix, name)) {
      return DependsOnWhat{.on = on, .joint = *joint};
    }
  }
  const bool is_reading = name.starts_with(kDial) && name.ends_with(kReading) &&
                          name.size() > kDial.size() + kReading.size();
  if (!is_reading) return std::nullopt;
  name.remove_prefix(kDial.size());
  name.remove_suffix(kReading.size());
  return DependsOnWhat{.on = DependsOn::kReading, .dial = std::string(name)};
}

}  // namespace sixdial::diagnosis
