#include "session/rig_deviations.h"

#include <fmt/format.h>

#include "geometry/units.h"
#include "session/toml_write.h"

namespace sixdial::session {
namespace {

using geometry::kRadPerDeg;

constexpr const char* kPosition = "position_sd_mm";
constexpr const char* kAxis = "axis_sd_deg";
constexpr const char* kTipRadius = "tip_radius_sd_mm";
constexpr const char* kSide = "side_sd_mm";
constexpr const char* kSquareness = "squareness_sd_deg";
constexpr const char* kOffset = "offset_sd_mm";

std::string line_in_mm(const char* key, const std::optional<double>& sd_mm) {
  return sd_mm ? fmt::format("{} = {}\n", key, toml_number(*sd_mm)) : std::string();
}

std::string line_in_deg(const char* key, const std::optional<double>& sd_rad) {
  return sd_rad ? fmt::format("{} = {}\n", key, toml_number(degrees_of(*sd_rad)))
                : std::string();
}

}  // namespace

const std::vector<std::string>& dial_deviation_keys() {
  static const std::vector<std::string> keys{kPosition, kAxis, kTipRadius};
  return keys;
}

const std::vector<std::string>& cuboid_deviation_keys() {
  static const std::vector<std::string> keys{kSide, kSquareness, kOffset};
  return keys;
}

void DeviationChecks::read_sd(
    const toml::table& from, const std::string& where, const char* key, double unit,
    std::optional<double>& sd) {
  if (from.get(key) == nullptr) return;
  const auto value = number(from, where, key);
  if (!value) return;
  if (*value < 0.0) {
    fault(
        from.get(key)->source(), key, fmt::format("is {} and may not be negative", *value),
        "write how well it is known, as a standard deviation; 0 if it is exact");
    return;
  }
  sd = *value * unit;
}

void DeviationChecks::read_deviations(
    const toml::table& from, const std::string& where, geometry::DialDeviations& deviations) {
  if (from.get(kPosition) != nullptr) {
    const auto sd = pair(from, where, kPosition);
    if (sd && sd->minCoeff() < 0.0) {
      fault(
          from.get(kPosition)->source(), kPosition, "may not be negative",
          "write standard deviations along and across the axis, such as [0.03, 0.1]");
    } else if (sd) {
      deviations.position_mm = *sd;
    }
  }
  read_sd(from, where, kAxis, kRadPerDeg, deviations.axis_rad);
  read_sd(from, where, kTipRadius, 1.0, deviations.tip_radius_mm);
}

void DeviationChecks::read_deviations(
    const toml::table& from, const std::string& where, geometry::CuboidDeviations& deviations) {
  read_sd(from, where, kSide, 1.0, deviations.side_mm);
  read_sd(from, where, kSquareness, kRadPerDeg, deviations.squareness_rad);
  read_sd(from, where, kOffset, 1.0, deviations.offset_mm);
}

std::string deviations_text(const geometry::DialDeviations& deviations) {
  std::string out;
  if (deviations.position_mm) {
    out += fmt::format("{} = {}\n", kPosition, toml_pair(*deviations.position_mm));
  }
  return out + line_in_deg(kAxis, deviations.axis_rad) +
         line_in_mm(kTipRadius, deviations.tip_radius_mm);
}

std::string deviations_text(const geometry::CuboidDeviations& deviations) {
  return line_in_mm(kSide, deviations.side_mm) +
         line_in_deg(kSquareness, deviations.squareness_rad) +
         line_in_mm(kOffset, deviations.offset_mm);
}

}  // namespace sixdial::session
