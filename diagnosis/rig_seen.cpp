#include "diagnosis/rig_seen.h"

#include <algorithm>
#include <cmath>

namespace sixdial::diagnosis {

double RigSeen::ratio() const { return known_sd > 0.0 ? std::abs(off) / known_sd : 0.0; }

std::vector<RigSeen> rig_as_seen(const Readings& readings, const JointFit& fit) {
  std::vector<RigSeen> result;
  Eigen::Index k = 0;
  for (const simulation::RigQuantity& each : readings.rig_quantities()) {
    if (k >= fit.known) break;
    const double of_known = each.sd / fit.known_sd_mm;  // u is in standard deviations x this mm
    result.push_back(
        {each.name, each.unit, fit.u[k] * of_known, fit.u_sd_mm[k] * of_known,
         each.sd / each.times, each.stated});
    ++k;
  }
  return result;
}

const RigSeen* worst_of(const std::vector<RigSeen>& rig) {
  const auto worst =
      std::ranges::max_element(rig, {}, [](const RigSeen& each) { return each.ratio(); });
  return worst == rig.end() ? nullptr : &*worst;
}

}  // namespace sixdial::diagnosis
