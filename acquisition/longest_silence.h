// How long a robot's controller may be silent before nobody waits for it and the run pauses.
#pragma once

#include "acquisition/bus.h"
#include "acquisition/clock.h"

namespace sixdial::acquisition {

/// 2 s, and half a second of the wall at least [device time].
[[nodiscard]] inline DeviceTime longest_silence(const Clock& clock) {
  constexpr std::chrono::milliseconds kLongest{2000};
  return at_least_on_wall(clock, kLongest, kLongest / 4);
}

}  // namespace sixdial::acquisition
