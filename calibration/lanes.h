// How many cases the vector kernels hold side by side, whatever the machine's vector unit.
#pragma once

namespace sixdial::calibration {

inline constexpr int kLanes = 8;

}  // namespace sixdial::calibration
