// What a robot's parameters leave of each dial's readings: the raw readings of all dials in
// contact against the simulation, not only the active three of a position.
#pragma once

#include <string>
#include <vector>

#include "session/session.h"

namespace sixdial::studies {

/// Reading minus simulated reading of one dial by the nominal and by the identified
/// parameters; robust where a gross error is among them (median, 1.48 times the median
/// distance from it).
struct DialRow {
  std::string dial{};
  int readings = 0;
  double before_median_mm = 0.0, median_mm = 0.0, spread_mm = 0.0, largest_mm = 0.0;
};

/// One row a dial that was read in contact, in the rig's order. The cuboid's clamp angle is the
/// one that the measured rotations ask for, by their median; with a free mount each sample's
/// own rotation counts. Samples without a rotation are left out.
[[nodiscard]] std::vector<DialRow> dial_residuals(
    const session::Session& session, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified);

}  // namespace sixdial::studies
