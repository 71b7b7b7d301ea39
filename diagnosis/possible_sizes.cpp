#include "diagnosis/possible_sizes.h"

#include <algorithm>
#include <cmath>

namespace sixdial::diagnosis {

bool sizes_are_possible(const JointFit& fit, std::size_t cause) {
  constexpr double kForSure = 3.0;  // standard deviations
  Eigen::Index column = fit.model.size();
  for (std::size_t k = 0; k < cause; ++k) column += fitted_count(*fit.effects[k].effect);
  const simulation::ActiveEffect& active = fit.effects[cause];
  bool all_declared = true;
  bool all_below = true;
  for (int k = 0; k < linear_count(*active.effect); ++k, ++column) {
    const auto parameter = simulation::parameter_at(*active.effect, active.place, k);
    if (!parameter) continue;
    const double size = active.x[static_cast<std::size_t>(k)];
    all_declared = all_declared && parameter->never_negative;
    all_below = all_below && size < 0;
    if (!parameter->never_negative) continue;
    const double sd = std::sqrt(std::max(0.0, fit.covariance(column, column)));
    if (size < -kForSure * sd) return false;
  }
  return !(all_declared && all_below);
}

}  // namespace sixdial::diagnosis
