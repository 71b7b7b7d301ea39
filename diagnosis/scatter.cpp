#include "diagnosis/scatter.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "calibration/rig_spaces.h"
#include "calibration/uncertainty.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

/// More scatter than the noise explains. A rig file's figure is a maker's word, not a
/// measurement: it must be missed by more.
bool scatters(const Noise& noise, double s_mm, double freedom) {
  if (!(noise.sigma_mm > 0) || freedom < 1) return false;
  const double ratio = s_mm * s_mm / (noise.sigma_mm * noise.sigma_mm);
  if (noise.degrees_of_freedom > 0) {
    const boost::math::fisher_f law(freedom, noise.degrees_of_freedom);
    return ratio > boost::math::quantile(boost::math::complement(law, kScatterLevel));
  }
  const boost::math::chi_squared law(freedom);
  return std::sqrt(ratio) > kMakersWord &&
         ratio * freedom > boost::math::quantile(boost::math::complement(law, kScatterLevel));
}

}  // namespace

Noise noise_of(const Readings& readings, const JointFit& fit, std::optional<std::size_t> only) {
  std::vector<simulation::Trial> trials = readings.trials();
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    const bool other = only && each.dial != static_cast<int>(*only);
    if (fit.weight[row] > kGoodWeight && !other) continue;
    auto& trial = trials[static_cast<std::size_t>(each.trial)];
    if (readings.has_dials()) {
      trial.reading[static_cast<std::size_t>(each.dial)].reset();
    } else {
      trial.position_mm.reset();
    }
  }
  const auto repeats = calibration::repeat_noise(trials, readings.has_dials());
  if (repeats && repeats->degrees_of_freedom >= calibration::kEnoughRepeats &&
      repeats->sigma_mm > 0) {
    return {NoiseSource::kRepeats, repeats->sigma_mm, repeats->degrees_of_freedom};
  }
  return {
      NoiseSource::kRigFile, only ? readings.rig_noise_of(*only) : readings.rig_noise_mm(), 0};
}

Scatter scatter_of(const Readings& readings, const JointFit& fit, const Noise& noise) {
  Scatter result;
  const std::size_t dials = readings.has_dials() ? readings.model().rig().dials.size() : 1;
  std::vector<double> squares(dials, 0.0);
  std::vector<double> freedom(dials, 0.0);
  std::vector<double> relative(dials, 1.0);
  const double share = 1 - fit.fitted / std::max(1.0 + fit.fitted, fit.weight.sum());
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const int dial = readings.rows()[static_cast<std::size_t>(row)].dial;
    const auto d = static_cast<std::size_t>(readings.has_dials() ? dial : 0);
    squares[d] += fit.weight[row] * fit.residual_mm[row] * fit.residual_mm[row];
    freedom[d] += share * fit.weight[row];
    relative[d] = fit.noise[row];
  }
  double in_noise = 0.0;
  double others = 0.0;
  for (std::size_t d = 0; d < dials; ++d) {
    if (freedom[d] <= 0) continue;
    const double sigma_mm = std::sqrt(squares[d] / freedom[d]);
    if (relative[d] > kUnevenFactor) {
      const Noise own = noise_of(readings, fit, d);
      if (scatters(own, sigma_mm, freedom[d])) {
        result.dials.push_back({readings.model().rig().dials[d].id, sigma_mm, own.sigma_mm});
      }
      continue;
    }
    in_noise += squares[d];
    others += freedom[d];
  }
  const double s_mm = std::sqrt(in_noise / std::max(1.0, others));
  result.of_all = scatters(noise, s_mm, others);
  return result;
}

}  // namespace sixdial::diagnosis
