// Time as the rig counts it. A mock rig may run faster than the wall: then every pause,
// deadline and time stamp toward the devices is in the rig's ("device") time, and this clock
// says how long that lasts on the wall.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stop_token>

#include "session/session.h"

namespace sixdial::acquisition {

/// Device time: since an arbitrary start, never backwards.
using DeviceTime = std::chrono::nanoseconds;

/// No wait for bytes gets a shorter deadline than this on the wall, however fast the rig's
/// clock runs: the two ends still share one operating system.
inline constexpr std::chrono::milliseconds kLeastWallTimeout{250};

/// May be used from any thread.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual DeviceTime monotonic() const = 0;
  [[nodiscard]] virtual session::TimePoint now_utc() const = 0;
  /// False if stopped before `deadline`.
  virtual bool sleep_until(DeviceTime deadline, const std::stop_token& stop) = 0;
  /// How long a span of device time lasts on the wall.
  [[nodiscard]] virtual std::chrono::nanoseconds wall(DeviceTime span) const = 0;

  bool sleep_for(DeviceTime span, const std::stop_token& stop) {
    return sleep_until(monotonic() + span, stop);
  }
  /// Wall time to wait for bytes that are due within `span` of device time.
  [[nodiscard]] std::chrono::nanoseconds wall_timeout(
      DeviceTime span, std::chrono::nanoseconds least = kLeastWallTimeout) const {
    return std::max(wall(span), least);
  }
};

/// False if stopped before `until`.
bool sleep_on_wall(std::chrono::steady_clock::time_point until, const std::stop_token& stop);

/// Device time is wall time.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] DeviceTime monotonic() const override;
  [[nodiscard]] session::TimePoint now_utc() const override;
  bool sleep_until(DeviceTime deadline, const std::stop_token& stop) override;
  [[nodiscard]] std::chrono::nanoseconds wall(DeviceTime span) const override { return span; }
};

/// t = start + speed * (steady - steady at construction).
class AcceleratedClock final : public Clock {
 public:
  /// Throws std::invalid_argument unless 0 < speed <= 1e6.
  AcceleratedClock(double speed, session::TimePoint start);
  [[nodiscard]] DeviceTime monotonic() const override;
  [[nodiscard]] session::TimePoint now_utc() const override;
  bool sleep_until(DeviceTime deadline, const std::stop_token& stop) override;
  [[nodiscard]] std::chrono::nanoseconds wall(DeviceTime span) const override;
  [[nodiscard]] double speed() const { return speed_; }

 private:
  double speed_;
  session::TimePoint start_;
  std::chrono::steady_clock::time_point steady_start_;
};

/// Stands still until told or slept on: a sleep returns at once, with the time moved on.
class FakeClock final : public Clock {
 public:
  explicit FakeClock(session::TimePoint start = session::TimePoint{}) : start_(start) {}
  [[nodiscard]] DeviceTime monotonic() const override { return DeviceTime(now_ns_.load()); }
  [[nodiscard]] session::TimePoint now_utc() const override;
  bool sleep_until(DeviceTime deadline, const std::stop_token& stop) override;
  [[nodiscard]] std::chrono::nanoseconds wall(DeviceTime span) const override { return span; }
  void advance(DeviceTime span) { now_ns_ += span.count(); }

 private:
  session::TimePoint start_;
  std::atomic<std::int64_t> now_ns_{0};
};

}  // namespace sixdial::acquisition
