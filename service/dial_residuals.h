// What a robot's parameters leave of each dial's readings: the raw readings of all dials in
// contact against the simulation, not only the active three of a position.
#pragma once

#include <vector>

#include "geometry/five_bar.h"
#include "report/report_data.h"
#include "session/session.h"

namespace sixdial::service {

/// One row a dial that was read in contact, in the rig's order. The cuboid's clamp angle is the
/// one that the measured rotations ask for, by their median; with a free mount each sample's
/// own rotation counts. Samples without a rotation are left out.
[[nodiscard]] std::vector<report::DialRow> dial_residuals(
    const session::Session& session, const geometry::ParameterVector& nominal,
    const geometry::ParameterVector& identified);

}  // namespace sixdial::service
