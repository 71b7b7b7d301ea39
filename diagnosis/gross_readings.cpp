#include "diagnosis/gross_readings.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

/// A joint with backlash is half of it off where nobody knows which side it came from.
bool of_unknown_side(const JointFit& fit, const simulation::Circumstance& sample) {
  return std::any_of(fit.effects.begin(), fit.effects.end(), [&](const ActiveEffect& active) {
    return (active.effect->needs & simulation::kApproach) != 0 && active.place.joint >= 0 &&
           sample.approach[active.place.joint] == 0;
  });
}

bool touches_near_edge(
    const geometry::Rig& rig, std::size_t dial, const simulation::Scene& at) {
  const geometry::DialGeometry& geometry = rig.dials[dial].geometry;
  const auto contact = geometry::contact_on_face(
      geometry, {at.p_WE, at.gamma_rad}, at.side_mm,
      geometry::face_towards(geometry, at.gamma_rad));
  constexpr double kTips = 2.0;  // radii of the tip: the pose is not known to less
  return std::abs(contact.along_mm) > at.side_mm / 2 - kTips * geometry.tip_radius_mm;
}

}  // namespace

std::vector<GrossReading> gross_readings(const Readings& readings, const JointFit& fit) {
  std::vector<GrossReading> result;
  const auto& rig = readings.model().rig();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  simulation::Scene scene;
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const double s_mm = fit.s_mm * fit.noise[row];
    if (std::abs(fit.residual_mm[row]) < kGrossSigma * s_mm || fit.weight[row] > kGoodWeight)
      continue;
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    const auto trial = static_cast<std::size_t>(each.trial);
    const simulation::Circumstance& sample = readings.circumstances()[trial];
    if (of_unknown_side(fit, sample)) continue;
    GrossReading gross{static_cast<int>(row), fit.residual_mm[row]};
    if (readings.has_dials()) {
      const auto dial = static_cast<std::size_t>(each.dial);
      gross.stale = std::abs(readings.measured_mm()[row] - sample.previous_mm[dial]) <
                    0.51 * rig.dials[dial].resolution_mm;
      gross.near_edge = extended.run(fit.model, readings.trials()[trial], sample, scene) &&
                        touches_near_edge(rig, dial, scene);
    }
    result.push_back(gross);
  }
  return result;
}

}  // namespace sixdial::diagnosis
