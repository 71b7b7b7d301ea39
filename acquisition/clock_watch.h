// Notices when the time of day is changed under a running collection. Ages and deadlines stand
// on the monotonic clock and do not mind; stored times are what the clock said, so that
// somebody must be told from when on they are others.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

#include "acquisition/clock.h"
#include "session/session.h"

namespace sixdial::acquisition {

struct ClockStep {
  std::chrono::milliseconds by{0};  // negative: back
  session::TimePoint now{};         // what the clock says since
};

/// "the computer's clock was set back by 3600.0 s".
[[nodiscard]] std::string describe(const ClockStep& step);

/// May be used from any thread.
class ClockWatch {
 public:
  /// Smaller ones are no step: a time service slews by them.
  static constexpr std::chrono::milliseconds kLeastStep{1000};

  explicit ClockWatch(const Clock& clock);
  /// The step of the time of day against the monotonic clock since the last look.
  [[nodiscard]] std::optional<ClockStep> look();

 private:
  struct Moment {
    session::TimePoint utc;
    DeviceTime monotonic;
    DeviceTime unsure;  // between the readings of the two clocks
  };
  [[nodiscard]] Moment now() const;

  const Clock& clock_;
  std::mutex mutex_;
  Moment last_;
};

}  // namespace sixdial::acquisition
