#include "acquisition/reading.h"

#include <algorithm>

namespace sixdial::acquisition {

Reading good_reading(double value_mm, DeviceTime requested, session::TimePoint time_utc) {
  Reading reading;
  reading.value_mm = value_mm;
  reading.quality = session::Quality::kGood;
  reading.reason.clear();
  reading.time_utc = time_utc;
  reading.requested = requested;
  return reading;
}

Reading bad_reading(const Fault& fault, DeviceTime requested, session::TimePoint time_utc) {
  Reading reading;
  reading.quality = session::Quality::kBad;
  reading.reason = std::string(reason(fault.kind));
  reading.detail = fault.detail;
  reading.time_utc = time_utc;
  reading.requested = requested;
  return reading;
}

void ReadingBoard::publish(std::size_t dial, Reading reading) {
  {
    const std::lock_guard lock(mutex_);
    Reading& place = newest_.at(dial);
    reading.sequence = place.sequence + 1;
    place = std::move(reading);
  }
  changed_.notify_all();
}

std::vector<Reading> ReadingBoard::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

bool ReadingBoard::wait_for_all(
    DeviceTime not_before, std::chrono::steady_clock::time_point deadline,
    const std::stop_token& stop) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, stop, deadline, [&] {
    return std::all_of(newest_.begin(), newest_.end(), [&](const Reading& each) {
      return each.sequence > 0 && each.requested >= not_before;
    });
  });
}

}  // namespace sixdial::acquisition
