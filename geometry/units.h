// Angles are radians everywhere inside; people read and write degrees. The factor between the
// two stands here and nowhere else (mock_devices/ uses it as well: it is no physics).
//   const double shown = rad * kDegPerRad;   const double rad = given_deg * kRadPerDeg;
//
// Example:
//   const ShownUnit shown = shown_unit("rad");
//   shown.name;  // -> "deg"
//   show(shown.per_unit * rig.robot.nominal[7]);  // alpha, in degrees
#pragma once

#include <numbers>
#include <string_view>

namespace sixdial::geometry {

inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// How a figure that is stored in `unit` is shown to people: in which unit, and shown value =
/// stored value * per_unit. Radians are shown in degrees, everything else as it is stored.
struct ShownUnit {
  std::string_view name;
  double per_unit = 1.0;
};
[[nodiscard]] constexpr ShownUnit shown_unit(std::string_view unit) {
  if (unit == "rad") return {"deg", kDegPerRad};
  return {unit, 1.0};
}

}  // namespace sixdial::geometry
