#include "acquisition/bus.h"

namespace sixdial::acquisition {

DeviceTime at_least_on_wall(
    const Clock& clock, DeviceTime span, std::chrono::nanoseconds least_wall) {
  const auto wall = clock.wall(span);
  if (wall >= least_wall || wall.count() <= 0) return span;
  const double stretch =
      static_cast<double>(least_wall.count()) / static_cast<double>(wall.count());
  return DeviceTime(static_cast<std::int64_t>(static_cast<double>(span.count()) * stretch));
}

}  // namespace sixdial::acquisition
