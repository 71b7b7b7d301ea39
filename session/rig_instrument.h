// The tables of a rig file that say what measures: [instrument], and the places it refers to,
// [[tool_point]], [[anchor]], [[socket]] and [[surface]] (doc/robots.md).
#pragma once

#include <string>

#include "geometry/rig.h"
#include "session/rig_deviations.h"

namespace sixdial::session {

class InstrumentChecks : protected DeviationChecks {
 protected:
  using DeviationChecks::DeviationChecks;
  /// [instrument] and its places, of a file that has such a table.
  void read_instrument_tables(const toml::table& top, geometry::Instrument& instrument);
  /// Adds a fault if the rig as read cannot have its instrument. Not of dials on a cuboid,
  /// whose faults have messages of their own.
  void check_instrument(const toml::table& top, const geometry::Rig& rig);

 private:
  [[nodiscard]] const toml::array* rows(const toml::table& top, const char* key);
  [[nodiscard]] std::optional<Eigen::Vector3d> triple(
      const toml::table& from, const std::string& where, const char* key);
  [[nodiscard]] geometry::ReferencePoint read_place(
      const toml::table& from, const std::string& where, std::vector<std::string> more_keys);
  void read_places(
      const toml::table& top, const char* key, std::vector<geometry::ReferencePoint>& places);
  void read_sockets(const toml::table& top, geometry::Instrument& instrument);
  void read_surfaces(const toml::table& top, std::vector<geometry::Surface>& surfaces);
};

}  // namespace sixdial::session
