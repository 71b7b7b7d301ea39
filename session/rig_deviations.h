// The keys of a rig file that say how well its own geometry is known (geometry/deviations.h):
// position_sd_mm = [along, across], axis_sd_deg and tip_radius_sd_mm of [dials] or a [[dial]],
// side_sd_mm, squareness_sd_deg and offset_sd_mm of [cuboid].
#pragma once

#include <string>
#include <vector>

#include "geometry/rig.h"
#include "session/toml_checks.h"

namespace sixdial::session {

[[nodiscard]] const std::vector<std::string>& dial_deviation_keys();
[[nodiscard]] const std::vector<std::string>& cuboid_deviation_keys();

class DeviationChecks : protected TomlChecks {
 protected:
  using TomlChecks::TomlChecks;
  /// Keys that are absent leave what `deviations` has.
  void read_deviations(
      const toml::table& from, const std::string& where, geometry::DialDeviations& deviations);
  void read_deviations(
      const toml::table& from, const std::string& where,
      geometry::CuboidDeviations& deviations);

 private:
  void read_sd(
      const toml::table& from, const std::string& where, const char* key, double unit,
      std::optional<double>& sd);
};

/// As a rig file has them, a line each; only what is stated.
[[nodiscard]] std::string deviations_text(const geometry::DialDeviations& deviations);
[[nodiscard]] std::string deviations_text(const geometry::CuboidDeviations& deviations);

}  // namespace sixdial::session
