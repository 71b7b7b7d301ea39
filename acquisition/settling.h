// Has a dial come to rest? Judged by the spread of its newest readings.
//
//   SettlingHistory history;
//   history.add(reading, 3, 150ms);
//   if (history.judged(3, 150ms, 0.012).settled) ...  // three readings, 0.15 s, 12 um
#pragma once

#include <deque>
#include <iterator>
#include <optional>

#include "acquisition/reading.h"

namespace sixdial::acquisition {

/// How near a dial is to rest, as the collector judges it.
struct DialSettling {
  std::optional<double> spread_mm;  // of its newest readings; empty: too few, or not touching
  double limit_mm = 0.0;            // settled within this
  bool settled = false;
};

/// The newest readings of one dial, just as many as judging needs.
class SettlingHistory {
 public:
  void forget() { moments_.clear(); }
  void add(const Reading& reading, int least, DeviceTime window);
  [[nodiscard]] bool has(int least) const { return std::ssize(moments_) >= least; }
  /// Settled: at least `least` readings over at least `window`, all touching or none, within
  /// `limit_mm`.
  [[nodiscard]] DialSettling judged(int least, DeviceTime window, double limit_mm) const;

 private:
  struct Moment {
    DeviceTime requested{0};
    std::optional<double> value_mm;
  };
  std::deque<Moment> moments_;
};

/// Within what the readings of a dial at rest stay [mm].
[[nodiscard]] double rest_spread_mm(double repeatability_mm);

}  // namespace sixdial::acquisition
