// When does a robot stand at the same pose again? One answer for all who ask: repeats that tell
// the noise, a plunger that has not moved since, the joint that arrived from the same side.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string_view>

namespace sixdial::geometry {

/// By so much do the encoders' values of two arrivals at one commanded pose differ: two counts
/// of a 17 bit encoder, some micrometres of a linear one. A commanded move is longer.
inline constexpr double kSamePose_rad = 1e-4;
inline constexpr double kSamePose_mm = 5e-3;

/// Of one joint, by the unit of its values ("rad", "mm").
[[nodiscard]] constexpr double same_pose(std::string_view unit) {
  return unit == "mm" ? kSamePose_mm : kSamePose_rad;
}

}  // namespace sixdial::geometry
