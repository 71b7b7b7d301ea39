// Notices when somebody changes the computer's time of day during a collection. Ages and
// deadlines use the monotonic clock and are not affected. Stored times are what the clock said,
// so the operator must be told from when on they differ.
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
  /// Smaller changes are no step: a time service makes them to keep the clock right.
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
