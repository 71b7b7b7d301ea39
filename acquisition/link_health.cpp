#include "acquisition/link_health.h"

#include <algorithm>

namespace sixdial::acquisition {

std::string_view to_string(LinkState state) {
  switch (state) {
    case LinkState::kOk:
      return "ok";
    case LinkState::kSuspect:
      return "suspect";
    case LinkState::kDown:
      return "down";
  }
  return "unknown";
}

void LinkHealth::good() {
  state_ = LinkState::kOk;
  bad_in_a_row_ = 0;
  wait_ = kFirstBackOff;
  next_try_ = DeviceTime{0};
}

void LinkHealth::bad(DeviceTime now) {
  ++bad_in_a_row_;
  if (state_ == LinkState::kOk) state_ = LinkState::kSuspect;
  if (bad_in_a_row_ >= kSuspectLimit) {
    state_ = LinkState::kDown;
    back_off(now);
  }
}

void LinkHealth::lost(DeviceTime now) {
  ++bad_in_a_row_;
  state_ = LinkState::kDown;
  back_off(now);
}

void LinkHealth::back_off(DeviceTime now) {
  next_try_ = now + wait_;
  wait_ = std::min<DeviceTime>(2 * wait_, kLongestBackOff);
}

}  // namespace sixdial::acquisition
