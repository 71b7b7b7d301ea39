#include "diagnosis/rig_columns.h"

#include <cmath>

namespace sixdial::diagnosis {

Eigen::MatrixXd rig_columns(
    const Readings& readings, const simulation::ModelVector& at,
    const std::vector<simulation::RigQuantity>& quantities) {
  Eigen::MatrixXd columns(readings.count(), static_cast<Eigen::Index>(quantities.size()));
  if (quantities.empty()) return columns;
  const simulation::ExtendedModel plain(readings.model(), {});
  const Eigen::VectorXd there = readings.simulate(at, plain);
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const simulation::RigQuantity& quantity = quantities[k];
    constexpr double kStep = 1e-3;  // standard deviations: small against what bends
    const simulation::ActiveEffect off{quantity.effect, quantity.place, {kStep * quantity.sd}};
    columns.col(static_cast<Eigen::Index>(k)) =
        (readings.simulate(at, plain, &off) - there) / kStep;
  }
  return columns.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

}  // namespace sixdial::diagnosis
