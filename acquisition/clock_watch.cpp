#include "acquisition/clock_watch.h"

#include <fmt/format.h>

#include <cmath>

namespace sixdial::acquisition {

std::string describe(const ClockStep& step) {
  const double by_s = std::chrono::duration<double>(step.by).count();
  return by_s < 0 ? fmt::format("the computer's clock was set back by {:.1f} s", -by_s)
                  : fmt::format(
                        "the computer's clock went forward by {:.1f} s (it was set, or the "
                        "computer slept)",
                        by_s);
}

ClockWatch::ClockWatch(const Clock& clock) : clock_(clock), last_(now()) {}

ClockWatch::Moment ClockWatch::now() const {
  const DeviceTime before = clock_.monotonic();
  const session::TimePoint utc = clock_.now_utc();
  const DeviceTime after = clock_.monotonic();
  return {utc, after, after - before};
}

std::optional<ClockStep> ClockWatch::look() {
  const std::lock_guard lock(mutex_);
  const Moment moment = now();
  const auto passed =
      std::chrono::duration_cast<std::chrono::milliseconds>(moment.monotonic - last_.monotonic);
  const auto by =
      std::chrono::duration_cast<std::chrono::milliseconds>(moment.utc - last_.utc) - passed;
  const DeviceTime least = DeviceTime(kLeastStep) + moment.unsure + last_.unsure;
  last_ = moment;
  if (std::chrono::abs(by) < least) return std::nullopt;
  return ClockStep{by, moment.utc};
}

}  // namespace sixdial::acquisition
