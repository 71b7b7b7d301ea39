#include "studies/seen_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sixdial::studies {

using diagnosis::RigSeen;
using simulation::RigQuantity;

std::vector<RigSeen> seen_of(const calibration::RigFit& fit) {
  std::vector<RigSeen> result;
  for (std::size_t k = 0; k < fit.quantities.size(); ++k) {
    const RigQuantity& each = fit.quantities[k];
    const auto i = static_cast<Eigen::Index>(k);
    result.push_back(
        {.name = each.name,
         .unit = each.unit,
         .off = fit.off[i] * each.sd,
         .sd = std::sqrt(fit.covariance(i, i)) * each.sd,
         .known_sd = each.sd,
         .stated = true});
  }
  return result;
}

geometry::Rig rig_as_seen(
    const geometry::Rig& file, const std::optional<std::vector<RigSeen>>& seen) {
  const std::vector<RigQuantity> quantities = simulation::stated_quantities(file);
  if (!seen || quantities.empty()) return file;
  Eigen::VectorXd off = Eigen::VectorXd::Zero(std::ssize(quantities));
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const auto found = std::ranges::find(*seen, quantities[k].name, &RigSeen::name);
    if (found == seen->end() || !std::isfinite(found->off)) continue;
    off[static_cast<Eigen::Index>(k)] = found->off / quantities[k].sd;
  }
  return calibration::moved_rig(file, off);
}

calibration::ObservationSpace with_rig_as_seen(
    calibration::ObservationSpace space, const std::optional<calibration::RigFit>& fit) {
  if (fit && space.rig_mm.cols() == fit->covariance.rows()) {
    space.rig_mm *= fit->left_open();
  }
  return space;
}

}  // namespace sixdial::studies
