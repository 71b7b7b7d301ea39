#include "acquisition/settling.h"

#include <algorithm>

namespace sixdial::acquisition {

void SettlingHistory::add(const Reading& reading, int least, DeviceTime window) {
  moments_.push_back({reading.requested, reading.value_mm});
  while (moments_.size() > static_cast<std::size_t>(least) &&
         moments_.back().requested - moments_[1].requested >= window) {
    moments_.pop_front();
  }
}

DialSettling SettlingHistory::judged(int least, DeviceTime window, double limit_mm) const {
  DialSettling judged{.spread_mm = {}, .limit_mm = limit_mm};
  if (moments_.size() < 2) return judged;
  const bool touching = moments_.front().value_mm.has_value();
  double low = moments_.front().value_mm.value_or(0.0);
  double high = low;
  for (const Moment& each : moments_) {
    if (each.value_mm.has_value() != touching) return judged;
    low = std::min(low, each.value_mm.value_or(low));
    high = std::max(high, each.value_mm.value_or(high));
  }
  if (touching) judged.spread_mm = high - low;
  judged.settled = moments_.size() >= static_cast<std::size_t>(least) &&
                   moments_.back().requested - moments_.front().requested >= window &&
                   high - low <= limit_mm;
  return judged;
}

double rest_spread_mm(double repeatability_mm) {
  constexpr double kLeast_mm = 0.005;
  // Readings at rest: 99.9 % of the spreads of some ten readings are below six sigma.
  constexpr double kSpreadPerSigma = 6.0;
  return std::max(kLeast_mm, kSpreadPerSigma * repeatability_mm);
}

}  // namespace sixdial::acquisition
