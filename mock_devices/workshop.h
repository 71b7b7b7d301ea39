// A rig as it stands in a workshop: its file says where the dials should be, and they stand a
// little elsewhere; and robot and dials have many small faults at once. All of it from a seed.
#pragma once

#include <cstdint>

#include "geometry/units.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {

/// Standard deviations of what stands elsewhere than the rig file says. 0: where it says.
struct Misplaced {
  double along_mm = 0.03;  // a dial along its axis: read off against a gauge block
  double across_mm = 0.1;  // across: read off a ruler
  double axis_rad = 0.1 * geometry::kRadPerDeg;
  double tip_radius_mm = 0.0;
  double side_mm = 0.0;
  double squareness_rad = 0.0;
  double offset_mm = 0.0;  // of the cuboid's centre from the tool, each axis
};
/// Where everything stands as the file says.
inline constexpr Misplaced kPlacedExactly{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

struct Workshop {
  geometry::Rig file;  // what people wrote down
  World world;         // what there is
};

/// Small faults: each gear runs out a little, links grow with the day, the base creeps, each
/// dial has a smooth error curve within +-6 um and a micrometre of hysteresis. `samples`: of
/// the session to come.
[[nodiscard]] Workshop drawn_workshop(
    const geometry::Rig& file, std::uint64_t seed, const Misplaced& misplaced = {},
    int samples = 150);

}  // namespace sixdial::mock_devices
