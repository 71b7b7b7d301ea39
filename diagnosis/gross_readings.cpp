#include "diagnosis/gross_readings.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

bool touches_near_edge(
    const geometry::Rig& rig, std::size_t dial, const simulation::Scene& at) {
  const geometry::DialGeometry& geometry = rig.dials[dial].geometry;
  const auto contact = geometry::contact_on_face(
      geometry, {at.p_WE.head<2>(), at.gamma_rad}, at.side_mm,
      geometry::face_towards(geometry, at.gamma_rad));
  constexpr double kTips = 2.0;  // radii of the tip: the pose is not known to less
  return std::abs(contact.along_mm) > at.side_mm / 2 - kTips * geometry.tip_radius_mm;
}

bool is_gross(const JointFit& fit, Eigen::Index row) {
  return std::abs(fit.residual_mm[row] - fit.shift_mm[row]) >=
             kGrossSigma * fit.s_mm * fit.noise[row] &&
         fit.weight[row] <= kGoodWeight;
}

}  // namespace

std::vector<bool> wrong_dials(const Readings& readings, const JointFit& fit) {
  std::vector<int> gross(readings.channel_count(), 0);
  std::vector<int> all = gross;
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const int dial = readings.rows()[static_cast<std::size_t>(row)].dial;
    ++all[static_cast<std::size_t>(dial)];
    gross[static_cast<std::size_t>(dial)] += is_gross(fit, row);
  }
  std::vector<bool> result;
  for (std::size_t d = 0; d < all.size(); ++d) {
    result.push_back(readings.has_dials() && gross[d] > kMostGrossOfADial * all[d]);
  }
  return result;
}

std::vector<GrossReading> gross_readings(const Readings& readings, const JointFit& fit) {
  std::vector<GrossReading> result;
  const auto& rig = readings.model().rig();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const std::vector<bool> wrong = wrong_dials(readings, fit);
  simulation::Scene scene;
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    if (!is_gross(fit, row) || wrong[static_cast<std::size_t>(each.dial)]) continue;
    const auto trial = static_cast<std::size_t>(each.trial);
    const simulation::Circumstance& sample = readings.circumstances()[trial];
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
