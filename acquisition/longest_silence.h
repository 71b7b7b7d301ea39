// How long a robot's controller may be silent before nobody waits for it and the run pauses.
#pragma once

#include "acquisition/bus.h"
#include "acquisition/clock.h"

namespace sixdial::acquisition {

/// 2 s [device time], and 2 s of the wall too: a fast clock has mocks for devices, and these
/// share the machine with whatever else it does.
[[nodiscard]] inline DeviceTime longest_silence(const Clock& clock) {
  constexpr std::chrono::milliseconds kLongest{2000};
  return at_least_on_wall(clock, kLongest, kLongest);
}

}  // namespace sixdial::acquisition
