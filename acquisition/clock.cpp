#include "acquisition/clock.h"

#include <fmt/format.h>

#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stdexcept>

namespace sixdial::acquisition {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

}  // namespace

bool sleep_on_wall(steady_clock::time_point until, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any changed;
  std::unique_lock lock(mutex);
  changed.wait_until(lock, stop, until, [] { return false; });
  return !stop.stop_requested();
}

DeviceTime SystemClock::monotonic() const { return steady_clock::now().time_since_epoch(); }

session::TimePoint SystemClock::now_utc() const {
  return std::chrono::time_point_cast<milliseconds>(std::chrono::system_clock::now());
}

bool SystemClock::sleep_until(DeviceTime deadline, const std::stop_token& stop) {
  return sleep_on_wall(steady_clock::time_point(deadline), stop);
}

AcceleratedClock::AcceleratedClock(double speed, session::TimePoint start)
    : speed_(speed), start_(start), steady_start_(steady_clock::now()) {
  if (!(speed > 0.0 && speed <= 1e6)) {
    throw std::invalid_argument(
        fmt::format("clock speed {} is not between 0 and 1e6; 1 is real time", speed));
  }
}

DeviceTime AcceleratedClock::monotonic() const {
  const auto elapsed = static_cast<double>((steady_clock::now() - steady_start_).count());
  return DeviceTime(std::llround(elapsed * speed_));
}

session::TimePoint AcceleratedClock::now_utc() const {
  return start_ + duration_cast<milliseconds>(monotonic());
}

bool AcceleratedClock::sleep_until(DeviceTime deadline, const std::stop_token& stop) {
  return sleep_on_wall(steady_start_ + wall(deadline), stop);
}

nanoseconds AcceleratedClock::wall(DeviceTime span) const {
  return nanoseconds(std::llround(static_cast<double>(span.count()) / speed_));
}

session::TimePoint FakeClock::now_utc() const {
  return start_ + duration_cast<milliseconds>(monotonic());
}

bool FakeClock::sleep_until(DeviceTime deadline, const std::stop_token& stop) {
  if (stop.stop_requested()) return false;
  std::int64_t now = now_ns_.load();
  while (now < deadline.count() && !now_ns_.compare_exchange_weak(now, deadline.count())) {
  }
  return true;
}

}  // namespace sixdial::acquisition
