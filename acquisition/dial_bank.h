// All dials of a rig, each on its cable: opens the buses, runs one thread for each, and hands
// out readings that are never older than they claim.
#pragma once

#include <memory>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "acquisition/bus.h"
#include "acquisition/reading.h"
#include "geometry/rig.h"

namespace sixdial::acquisition {

/// A spindle at its end stop shows a constant near zero; below this it touches nothing.
inline constexpr double kNoContact_mm = 0.02;
/// A value older than this is stale [device time].
inline constexpr std::chrono::milliseconds kOldestReading{3000};

/// A value at the end stop becomes a good reading without value, "no contact".
[[nodiscard]] Reading without_end_stop(Reading reading);

/// Any thread. Stops and joins its threads when destroyed, within their deadlines.
class DialBank final : public DialSource {
 public:
  /// Starts to read; a device that is not there yet is a fault of its dials, not an error. The
  /// error lists every connection string that cannot be used. `clock` must outlive the bank.
  [[nodiscard]] static tl::expected<std::unique_ptr<DialBank>, std::string> open(
      const geometry::Rig& rig, Clock& clock);
  ~DialBank() override;

  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] std::vector<Reading> read_since(
      DeviceTime not_before, const std::stop_token& stop) override;
  [[nodiscard]] std::vector<Reading> latest() const override;
  /// Readings of all dials that were asked for from now on: read_since(now).
  [[nodiscard]] std::vector<Reading> scan(const std::stop_token& stop);
  [[nodiscard]] std::vector<BusStatus> buses() const;

 private:
  DialBank(std::size_t dials, Clock& clock);

  std::size_t size_;
  Clock& clock_;
  ReadingBoard board_;
  std::vector<std::unique_ptr<Bus>> buses_;
  std::vector<std::jthread> workers_;  // last: they end before what they use
};

}  // namespace sixdial::acquisition
