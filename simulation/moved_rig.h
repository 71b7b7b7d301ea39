// A rig whose dials and cuboid are a little off from what its file says.
//
//   moved_rig(rig, stated_quantities(rig), off);  // off: in their standard deviations
#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/rig.h"
#include "simulation/rig_quantities.h"

namespace sixdial::simulation {

/// A rig can say it. Of the cuboid's squareness and centre it cannot: these are known to
/// effects alone.
[[nodiscard]] bool is_said_by_a_rig(const RigQuantity& quantity, const geometry::Rig& rig);

/// Each quantity off by so many of its standard deviations, as far as a rig can say it.
[[nodiscard]] geometry::Rig moved_rig(
    const geometry::Rig& rig, std::span<const RigQuantity> quantities,
    const Eigen::VectorXd& off);

}  // namespace sixdial::simulation
