// One cable with the dials on it. A bus runs in one thread of its own, puts what it reads on
// the board, and ends within its deadline (300 ms) of being asked to stop.
#pragma once

#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/clock.h"
#include "acquisition/fault.h"
#include "acquisition/link_health.h"
#include "acquisition/reading.h"

namespace sixdial::acquisition {

/// A dial's figures that a bus needs to judge its values.
struct DialLimits {
  std::size_t dial = 0;  // place on the board
  std::string id;
  double resolution_mm = 0.001;
  double travel_mm = 50.8;
};

struct BusStatus {
  std::string name;  // "127.0.0.1:1502", "/dev/ttyUSB0"
  LinkState state = LinkState::kDown;
  std::uint64_t scans = 0;   // complete rounds of its dials
  std::uint64_t faults = 0;  // bad answers, all dials
  std::uint64_t reconnections = 0;
  std::string last_fault;  // in words
};

class Bus {
 public:
  virtual ~Bus() = default;
  /// Reads until stopped. Throws only for a broken program, never for a device.
  virtual void run(const std::stop_token& stop) = 0;
  [[nodiscard]] BusStatus status() const {
    const std::lock_guard lock(status_mutex_);
    return status_;
  }

 protected:
  template <typename Change>
  void change_status(Change change) {
    const std::lock_guard lock(status_mutex_);
    change(status_);
  }

 private:
  mutable std::mutex status_mutex_;
  BusStatus status_;
};

/// Least time between the starts of two scans on the wall clock; without it, threads would spin
/// under an accelerated device clock.
inline constexpr std::chrono::milliseconds kLeastScanPeriod{4};
/// At most 50 scans a second [device time], so that a rig reaches 40 in any case.
inline constexpr std::chrono::milliseconds kScanPeriod{20};
/// While a bus is down its fault is repeated this often, so that nobody waits for it.
inline constexpr std::chrono::milliseconds kDownPeriod{100};
/// After an error a line is left alone for this long: longer than the slowest device answers.
inline constexpr std::chrono::milliseconds kQuiet{1000};

/// `span`, or more of device time if that is shorter than `least_wall` on the wall.
[[nodiscard]] DeviceTime at_least_on_wall(
    const Clock& clock, DeviceTime span, std::chrono::nanoseconds least_wall);

}  // namespace sixdial::acquisition
