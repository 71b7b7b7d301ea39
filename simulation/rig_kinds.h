// Quantities of the rig by kind, and what the rig file says of each.
//
//   kind_of(quantity);       // "places of the dials across their axes"
//   said_of(rig, quantity);  // 0.1 [mm]
#pragma once

#include <optional>
#include <string_view>

#include "geometry/rig.h"
#include "simulation/rig_quantities.h"

namespace sixdial::simulation {

[[nodiscard]] std::string_view kind_of(const RigQuantity& quantity);
/// Its standard deviation by the file: 0 is exact; empty: it does not say.
[[nodiscard]] std::optional<double> said_of(
    const geometry::Rig& rig, const RigQuantity& quantity);

}  // namespace sixdial::simulation
