// What the rig file may have a little wrong about the rig itself: where each dial stands and
// how it leans, its tip, the cuboid. None of it is the robot's fault, and each bends what the
// dials read. Spec 8: a quantity that the file gives with a standard deviation is a parameter
// with that prior; where the file claims exactness, all of them together are one suspicion.
//
// Example:
//   for (const RigQuantity& each : stated_quantities(rig)) show(each.name, each.sd);
#pragma once

#include <string>
#include <vector>

#include "simulation/effect.h"

namespace sixdial::simulation {

struct RigQuantity {
  std::string name;  // "place of dial C across its axis"
  std::string unit;  // "mm" or "rad"
  double sd = 0.0;   // in it, as fits use it: stated, or what a workshop knows, by `times`
  bool stated = false;
  double times = 1.0;  // 1 until the readings have changed it (diagnosis/rig_known.h)
  Place place{};
  const Effect* effect = nullptr;  // one parameter: by how much it is off
};

/// Those that the rig file gives with a standard deviation above 0.
[[nodiscard]] std::vector<RigQuantity> stated_quantities(const geometry::Rig& rig);
/// All others, with the standard deviations of a ruler, a square and a gauge block.
[[nodiscard]] std::vector<RigQuantity> claimed_quantities(const geometry::Rig& rig);

}  // namespace sixdial::simulation
