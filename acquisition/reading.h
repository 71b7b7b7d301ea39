// One dial's reading with when and how good, and the board on which the buses' threads put the
// newest of each dial for everyone else to look at.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/clock.h"
#include "acquisition/fault.h"
#include "session/session.h"

namespace sixdial::acquisition {

struct Reading {
  std::optional<double> value_mm;
  session::Quality quality = session::Quality::kBad;
  std::string reason = "never read";  // empty if good
  std::string detail;                 // evidence for people
  session::TimePoint time_utc{};      // when the answer was there
  DeviceTime requested{-1};           // when it was asked for
  std::uint64_t sequence = 0;  // counts the answers of this dial, faults too; 0: none yet
};

[[nodiscard]] Reading good_reading(
    double value_mm, DeviceTime requested, session::TimePoint time_utc);
[[nodiscard]] Reading bad_reading(
    const Fault& fault, DeviceTime requested, session::TimePoint time_utc);

/// Of all dials of a rig. Any thread.
class ReadingBoard {
 public:
  explicit ReadingBoard(std::size_t dials) : newest_(dials) {}

  /// Gives the reading its sequence number.
  void publish(std::size_t dial, Reading reading);
  [[nodiscard]] std::vector<Reading> newest() const;
  /// Waits until each dial has answered (or failed to) a request made at or after `not_before`.
  /// False if some had not by the deadline on the wall clock, or if stopped.
  [[nodiscard]] bool wait_for_all(
      DeviceTime not_before, std::chrono::steady_clock::time_point deadline,
      const std::stop_token& stop) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  std::vector<Reading> newest_;
};

/// What the collector sees of the dials; DialBank is the real one.
class DialSource {
 public:
  virtual ~DialSource() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// One reading a dial, each asked for at or after `not_before`; a dial that gave none by then
  /// has a fault. Never an older value.
  [[nodiscard]] virtual std::vector<Reading> read_since(
      DeviceTime not_before, const std::stop_token& stop) = 0;
  /// The newest of each dial, for display; too old ones have lost their value ("stale").
  [[nodiscard]] virtual std::vector<Reading> latest() const = 0;
};

}  // namespace sixdial::acquisition
