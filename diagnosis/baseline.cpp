#include "diagnosis/baseline.h"

#include <algorithm>
#include <utility>

#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

bool looks_wrong(const Readings& readings, const JointFit& fit) {
  const double gross =
      1.0 - fit.weight.sum() / static_cast<double>(std::max<Eigen::Index>(1, readings.count()));
  return gross >= kMuchGross || fit.s_mm >= kFarOff * readings.rig_noise_mm();
}

JointFit doubtful_start() {
  JointFit result;
  result.gross_share = kLeastGrossShare;
  return result;
}

JointFit fit_baseline(const Readings& readings) {
  JointFit best = fit_jointly(readings, readings.nominal(), {});
  if (!readings.has_dials() || !looks_wrong(readings, best)) return best;
  for (std::size_t dial = 0; dial < readings.model().rig().dials.size(); ++dial) {
    const JointFit others = fit_jointly(readings.without_dial(dial), readings.nominal(), {});
    JointFit fit = fit_jointly(readings, others.model, {}, &others);
    if (fit.log_likelihood > best.log_likelihood) best = std::move(fit);
  }
  return best;
}

}  // namespace sixdial::diagnosis
