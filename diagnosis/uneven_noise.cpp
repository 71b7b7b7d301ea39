#include "diagnosis/uneven_noise.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

std::vector<double> uneven_noise(const Readings& readings, const JointFit& fit) {
  if (!readings.has_dials() || fit.weight.sum() <= fit.fitted + kFewestOfADial) return {};
  const std::size_t dials = readings.model().rig().dials.size();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dials));
  Eigen::VectorXd freedom = squares;
  Eigen::VectorXd before = Eigen::VectorXd::Ones(squares.size());
  const Eigen::VectorXd e = residual_at_rest_mm(readings, fit);
  const Eigen::VectorXd leverage = fit.whitening().leverage();
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const Eigen::Index dial = readings.rows()[static_cast<std::size_t>(row)].dial;
    squares[dial] += fit.weight[row] * e[row] * e[row];
    freedom[dial] += fit.weight[row] * (1 - leverage[row]);
    before[dial] = readings.relative_noise()[row];
  }
  freedom *= 1 - fit.fitted / fit.weight.sum();
  const Eigen::VectorXd relative = squares.cwiseQuotient(before.cwiseAbs2());
  bool uneven = false;
  std::vector<double> result(dials);
  for (Eigen::Index d = 0; d < squares.size(); ++d) {
    const double others = freedom.sum() - freedom[d];
    const bool enough = freedom[d] >= kFewestOfADial && others >= kFewestOfADial;
    double ratio = 1.0;
    if (enough) ratio = relative[d] / freedom[d] / ((relative.sum() - relative[d]) / others);
    const double large = std::max(ratio, 1 / ratio);
    if (enough && std::sqrt(large) > kUnevenFactor) {
      const boost::math::fisher_f law(
          ratio > 1 ? freedom[d] : others, ratio > 1 ? others : freedom[d]);
      uneven = uneven || boost::math::cdf(boost::math::complement(law, large)) < kUnevenLevel;
    }
    result[static_cast<std::size_t>(d)] =
        enough ? std::sqrt(squares[d] / freedom[d]) : fit.s_mm * before[d];
  }
  return uneven ? result : std::vector<double>{};
}

double noise_cost(const Readings& readings) {
  if (!readings.has_dials()) return 0.0;
  double cost = 0.0;
  const std::size_t dials = readings.model().rig().dials.size();
  bool own = false;
  for (std::size_t d = 0; d < dials; ++d) {
    own = own || readings.noise_of_dial()[d] != readings.rig_noise_of(d);
    const auto count = static_cast<double>(readings.rows_of_dial(d).size());
    if (count > 1) cost += 0.5 * std::log(count);
  }
  return own ? cost : 0.0;
}

}  // namespace sixdial::diagnosis
