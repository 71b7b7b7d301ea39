// How long a robot's controller has been silent, and how long it may be before nobody waits for
// it and the run pauses.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>

#include "acquisition/bus.h"
#include "acquisition/clock.h"

namespace sixdial::acquisition {

/// 2 s [device time], and 2 s of the wall too: a fast clock has mocks for devices, and these
/// share the machine with whatever else it does.
[[nodiscard]] inline DeviceTime longest_silence(const Clock& clock) {
  constexpr std::chrono::milliseconds kLongest{2000};
  return at_least_on_wall(clock, kLongest, kLongest);
}

/// Any thread.
class Silence {
 public:
  /// Whether what was asked at `asked` was answered.
  void note(bool came, DeviceTime asked) {
    if (came) {
      since_ = 0;
    } else if (since_ == 0) {
      since_ = std::max<DeviceTime::rep>(1, asked.count());
    }
  }
  /// [device time]; 0: it answers.
  [[nodiscard]] std::chrono::milliseconds lasts(const Clock& clock) const {
    const DeviceTime::rep since = since_;
    if (since == 0) return std::chrono::milliseconds(0);
    return std::chrono::duration_cast<std::chrono::milliseconds>(
        clock.monotonic() - DeviceTime(since));
  }

 private:
  std::atomic<DeviceTime::rep> since_{0};  // 0: it answers
};

}  // namespace sixdial::acquisition
