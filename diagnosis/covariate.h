// What an unexplained rest may depend on. Results and documents carry the name; only this file
// makes names, and takes them apart again.
//
// Example:
//   dependence_name({.on = DependsOn::kReading, .dial = "C"});  // -> "dial C reading"
//   dependence_from("approach2")->joint;                        // -> 1
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sixdial::diagnosis {

enum class DependsOn {
  kJointAngle,
  kToolX,
  kToolY,
  kToolZ,
  kCuboidAngle,
  kTime,
  kTemperature,
  kApproach,  // side that a joint arrives from
  kWeight,    // that a joint carries
  kReading,   // of one dial
};
struct DependsOnWhat {
  DependsOn on = DependsOn::kTime;
  int joint = -1;      // of kJointAngle, kApproach and kWeight, from 0
  std::string dial{};  // of kReading: its id
};

/// "x", "z", "gamma", "time", "temperature", "approach2", "weight2", "dial C reading"; "theta"
/// and the number of a joint.
[[nodiscard]] std::string dependence_name(const DependsOnWhat& what);
/// Empty: no name of these.
[[nodiscard]] std::optional<DependsOnWhat> dependence_from(std::string_view name);

}  // namespace sixdial::diagnosis
