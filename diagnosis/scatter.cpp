#include "diagnosis/scatter.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <map>
#include <utility>

#include "calibration/noise.h"
#include "diagnosis/gross_readings.h"
#include "diagnosis/shareable.h"
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

/// Pooled variance of what the fit leaves at repeats of one pose: what the model says of a pose
/// falls out, and so does the jitter of the encoders. Repeats of a point from another side are
/// another pose.
class Repeats {
 public:
  Repeats(const Readings& readings, const JointFit& fit, std::optional<std::size_t> only) {
    const auto& trials = readings.trials();
    for (Eigen::Index row = 0; row < readings.count(); ++row) {
      const Row& each = readings.rows()[static_cast<std::size_t>(row)];
      if (fit.weight[row] <= kGoodWeight) continue;
      if (only && each.dial != static_cast<int>(*only)) continue;
      groups_[{trials[static_cast<std::size_t>(each.trial)].point, each.dial}].push_back(row);
    }
    own_mm_ = fit.own_residual_mm();
    leverage_ = fit.whitening().leverage();
    for (const auto& [key, rows] : groups_) add(readings, rows);
  }
  [[nodiscard]] int freedom() const { return static_cast<int>(freedom_); }
  [[nodiscard]] double sigma_mm() const {
    return std::sqrt(squares_ / std::max(1.0, freedom_));
  }

 private:
  void add(const Readings& readings, const std::vector<Eigen::Index>& rows) {
    if (rows.size() < 2) return;
    const auto count = static_cast<double>(rows.size());
    double sum = 0.0;
    double taken = 0.0;  // by what the readings of an arrival share
    for (const Eigen::Index row : rows) {
      if (!at_same_pose(readings, rows.front(), row)) return;
      sum += own_mm_[row];
      taken += leverage_[row];
    }
    const double mean = sum / count;
    for (const Eigen::Index row : rows) squares_ += std::pow(own_mm_[row] - mean, 2);
    freedom_ += (count - 1) * (1 - taken / count);
  }

  std::map<std::pair<int, int>, std::vector<Eigen::Index>> groups_;  // by point and channel
  Eigen::VectorXd own_mm_, leverage_;
  double squares_ = 0.0;
  double freedom_ = 0.0;
};

}  // namespace

Noise noise_of(const Readings& readings, const JointFit& fit, std::optional<std::size_t> only) {
  const Repeats repeats(readings, fit, only);
  if (repeats.freedom() >= calibration::kEnoughRepeats && repeats.sigma_mm() > 0) {
    return {NoiseSource::kRepeats, repeats.sigma_mm(), repeats.freedom()};
  }
  return {
      NoiseSource::kRigFile, only ? readings.rig_noise_of(*only) : readings.rig_noise_mm(), 0};
}

namespace {

/// What each reading scatters by besides the noise. The bounds of both variances are taken
/// together, which makes the interval a little wide.
ScatterFound beside_noise(const Noise& noise, double s_mm, double freedom) {
  constexpr double kTail = 0.025;
  const auto bound = [&](double sigma_mm, double degrees, bool upper) {
    const boost::math::chi_squared law(degrees);
    const double quantile = upper ? boost::math::quantile(law, kTail)
                                  : boost::math::quantile(boost::math::complement(law, kTail));
    return sigma_mm * std::sqrt(degrees / quantile);
  };
  const auto of_noise = [&](bool upper) {
    const int degrees = noise.degrees_of_freedom;
    return degrees > 0 ? bound(noise.sigma_mm, degrees, upper) : noise.sigma_mm;
  };
  const auto beside = [](double whole, double part) {
    return std::sqrt(std::max(0.0, whole * whole - part * part));
  };
  return {
      ScatterIn::kReadings, beside(s_mm, noise.sigma_mm),
      beside(bound(s_mm, freedom, false), of_noise(true)),
      beside(bound(s_mm, freedom, true), of_noise(false))};
}

/// A dial that has nothing to do with what the simulation says.
NoisyDial wrong_dial(const Readings& readings, const JointFit& fit, std::size_t dial) {
  double squares = 0.0;
  const auto& rows = readings.rows_of_dial(dial);
  for (const Eigen::Index row : rows) squares += std::pow(fit.residual_mm[row], 2);
  return {
      readings.model().rig().dials[dial].id,
      std::sqrt(squares / static_cast<double>(rows.size())), readings.rig_noise_of(dial)};
}

}  // namespace

Scatter scatter_of(const Readings& readings, const JointFit& fit, const Noise& noise) {
  Scatter result;
  const std::size_t dials = readings.has_dials() ? readings.model().rig().dials.size() : 1;
  std::vector<double> squares(dials, 0.0);
  std::vector<double> freedom(dials, 0.0);
  std::vector<double> relative(dials, 1.0);
  const double share = 1 - fit.fitted / std::max(1.0 + fit.fitted, fit.weight.sum());
  const Eigen::VectorXd e = residual_at_rest_mm(readings, fit);
  const Eigen::VectorXd leverage = fit.whitening().leverage();
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const int dial = readings.rows()[static_cast<std::size_t>(row)].dial;
    const auto d = static_cast<std::size_t>(readings.has_dials() ? dial : 0);
    squares[d] += fit.weight[row] * e[row] * e[row];
    freedom[d] += share * fit.weight[row] * (1 - leverage[row]);
    // Of one instrument each reading has a sigma of its own: no channel stands apart.
    if (readings.has_dials()) relative[d] = readings.relative_noise()[row];
  }
  double in_noise = 0.0;
  double others = 0.0;
  const std::vector<bool> wrong = wrong_dials(readings, fit);
  for (std::size_t d = 0; d < dials; ++d) {
    if (d < wrong.size() && wrong[d]) {
      result.dials.push_back(wrong_dial(readings, fit, d));
      continue;
    }
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
  if (result.of_all) result.found = beside_noise(noise, s_mm, others);
  if (const auto size = fit.scatter(true)) {
    const ScatterOf of = fit.shared->of;
    const double per_unit = tool_motion_mm(readings, fit.model, of);
    result.found = {
        of == ScatterOf::kTool ? ScatterIn::kTool : ScatterIn::kJoints, per_unit * size->sd,
        per_unit * size->low, per_unit * size->high};
  }
  return result;
}

}  // namespace sixdial::diagnosis
