#include "diagnosis/rig_fit.h"

#include <algorithm>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/command_fit.h"
#include "diagnosis/drawn_samples.h"
#include "diagnosis/naming.h"
#include "diagnosis/normal_inverse.h"
#include "diagnosis/unknown.h"
#include "diagnosis/unnamed.h"
#include "simulation/moved_rig.h"

namespace sixdial::diagnosis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kMostTrials = 1500;  // as a diagnosis draws
constexpr std::uint64_t kSeed = 1;         // of which these are
// A free mount brings an unknown angle with each sample.
constexpr std::size_t kMostFreeTrials = 600;

struct Fitted {
  JointFit fit;
  double curve_scale_mm = 1.0;  // s when the curves were scaled to it
};

MatrixXd beside(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

/// With the dials' curves, with what is smooth and shows, and with what a robot may have
/// besides (unnamed.h).
Fitted fitted(Readings& readings) {
  JointFit fit = fit_baseline(readings);
  readings.place_tool(fit.model);
  const MatrixXd curves_mm = error_curves(readings);
  Fitted result;
  MatrixXd others(readings.count(), 0);
  const auto fit_again = [&] {
    result.curve_scale_mm = fit.s_mm;  // priors of further columns are in s
    fit = fit_jointly(
        readings, fit.model, {}, &fit, beside(curves_mm / result.curve_scale_mm, others));
  };
  fit_again();
  constexpr int kMostSmooth = 3;
  for (int more = 0; more < kMostSmooth; ++more) {
    std::vector<UnknownCandidate> smooth = score_unknown(readings, fit);
    std::erase_if(smooth, [](const auto& each) { return each.kind != UnknownKind::kSmooth; });
    if (smooth.empty() || smooth.front().evidence <= 0.0) break;
    others = beside(others, smooth.front().columns);
    fit_again();
  }
  others = beside(others, unnamed_columns(readings, fit) / fit.s_mm);
  fit_again();
  result.fit = std::move(fit);
  return result;
}

}  // namespace

std::optional<RigFit> fit_rig(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  RigFit result{rig, simulation::stated_quantities(rig), {}, {}, {}, {}};
  const auto count = static_cast<Index>(result.quantities.size());
  if (count == 0 || rig.dials.empty()) return std::nullopt;
  geometry::Rig by_dials = rig;
  by_dials.instrument.kind = "dials_on_cuboid";
  const simulation::ForwardModel model(by_dials);
  std::vector<simulation::Trial> all(trials.begin(), trials.end());
  const std::vector<bool> drawn = drawn_samples(
      all, std::vector<bool>(all.size(), false),
      rig.cuboid.mount == geometry::Mount::kFree ? kMostFreeTrials : kMostTrials, kSeed);
  Readings readings(model, std::move(all), drawn);
  if (!readings.has_dials() || readings.count() <= 2 * model.nominal().size()) {
    return std::nullopt;
  }
  readings.place_tool(model.nominal());
  const auto [fit, curve_scale_mm] = fitted(readings);
  if (!fit.converged || fit.known < count) return std::nullopt;
  const Index shapes = calibration::kCurveShapes * static_cast<Index>(rig.dials.size());
  // From s of each prior to its standard deviations. Angles of a free mount lie between.
  std::vector<Index> at;
  VectorXd mean(count + shapes), of_prior(count + shapes);
  const VectorXd scaled = fit.scaled_u();
  for (Index k = 0; k < count + shapes; ++k) {
    const bool is_curve = k >= count;
    at.push_back(is_curve ? fit.known + (k - count) : k);
    of_prior[k] = is_curve ? fit.s_mm / curve_scale_mm : 1.0;
    mean[k] = scaled[at.back()] / fit.s_mm * of_prior[k];
  }
  const MatrixXd unit = NormalInverse(fit).covariance_of_u;
  const MatrixXd covariance = of_prior.asDiagonal() * unit(at, at) * of_prior.asDiagonal();
  result.off = mean.head(count);
  result.covariance = covariance.topLeftCorner(count, count);
  result.rig = simulation::moved_rig(rig, result.quantities, result.off);
  for (Index k = 0; k < count; ++k) {
    if (is_said_by_a_rig(result.quantities[static_cast<std::size_t>(k)], rig)) mean[k] = 0.0;
  }
  result.open = covariance + mean * mean.transpose();
  result.ranges = calibration::reading_ranges(trials, rig.dials.size());
  return result;
}

}  // namespace sixdial::diagnosis
