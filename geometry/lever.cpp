#include "geometry/lever.h"

#include <algorithm>

namespace sixdial::geometry {

double lever_mm(const InstrumentModel& instrument) {
  double length_mm = 0.0;
  double angle_rad = 0.0;
  for (const ChannelInfo& channel : instrument.channels) {
    double& most = channel.unit == "rad" ? angle_rad : length_mm;
    most = std::max(most, channel.sd);
  }
  return length_mm > 0 && angle_rad > 0 ? length_mm / angle_rad : kUsualLever_mm;
}

}  // namespace sixdial::geometry
