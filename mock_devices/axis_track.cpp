#include "mock_devices/axis_track.h"

#include <algorithm>
#include <cmath>

namespace sixdial::mock_devices {

void AxisTrack::append(const std::vector<double>& to, double speed, double time_s) {
  const std::vector<double> from = end();
  double way = 0.0;
  for (std::size_t i = 0; i < to.size(); ++i) way = std::hypot(way, to[i] - from[i]);
  const double start_s = std::max(time_s, end_s());
  if (!moves(time_s)) {  // the old ones are done
    at_ = from;
    legs_.clear();
  }
  legs_.push_back({from, to, start_s, start_s + way / speed, speed});
}

void AxisTrack::stop(double time_s) {
  at_ = position(time_s);
  legs_.clear();
}

std::vector<double> AxisTrack::position(double time_s) const {
  std::vector<double> now = at_;
  for (const Leg& leg : legs_) {
    if (time_s < leg.start_s) break;
    const double share = leg.end_s > leg.start_s
                             ? std::min(1.0, (time_s - leg.start_s) / (leg.end_s - leg.start_s))
                             : 1.0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i] = leg.from[i] + share * (leg.to[i] - leg.from[i]);
    }
  }
  return now;
}

bool AxisTrack::moves(double time_s) const { return time_s < end_s(); }

double AxisTrack::speed(double time_s) const {
  for (const Leg& leg : legs_) {
    if (time_s >= leg.start_s && time_s < leg.end_s) return leg.speed;
  }
  return 0.0;
}

}  // namespace sixdial::mock_devices
