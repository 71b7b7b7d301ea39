#include "diagnosis/exchanged_dials.h"

#include <algorithm>
#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

/// A free shift of each dial: what is asked before an exchange is. Dials that stand a little
/// off would else be explained by the exchange of two others, with a part of the readings left
/// out.
Eigen::MatrixXd mounting_columns(const Readings& readings) {
  constexpr double kPrior_mm = 1.0;
  const double per_noise = kPrior_mm / std::max(1e-6, readings.rig_noise_mm());
  const Eigen::MatrixXd& others = readings.nuisance();
  const auto dials = static_cast<Eigen::Index>(readings.channel_count());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(readings.count(), others.cols() + dials);
  columns.leftCols(others.cols()) = others;
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    columns(row, others.cols() + each.dial) = per_noise;
  }
  return columns;
}

/// The likeliest of the fits from three starts, every dial free to stand elsewhere.
JointFit fit_with_mounting(const Readings& readings, const simulation::ModelVector& start) {
  const Eigen::MatrixXd columns = mounting_columns(readings);
  const simulation::ModelVector& nominal = readings.nominal();
  JointFit best = fit_jointly(readings, nominal, {}, nullptr, columns);
  const auto keep_likelier = [&](JointFit fit) {
    if (fit.log_likelihood > best.log_likelihood) best = std::move(fit);
  };
  keep_likelier(fit_jointly(readings, start, {}, nullptr, columns));
  const JointFit doubtful = doubtful_start();
  keep_likelier(fit_jointly(readings, nominal, {}, &doubtful, columns));
  return best;
}

}  // namespace

std::optional<Hypothesis> find_exchanged_dials(
    Readings& readings, const std::vector<Hypothesis>& hypotheses, JointFit& baseline) {
  if (!looks_wrong(readings, baseline)) return std::nullopt;
  std::optional<Hypothesis> found;
  std::optional<Readings> best_readings;
  JointFit best = fit_with_mounting(readings, baseline.model);
  double best_likelihood = best.log_likelihood + kExchangeLogOdds;
  const double left_out_before = best.left_out();
  // With nothing left but noise no exchange can be better, and none is tried.
  constexpr double kNearlyNoise = 3.0;
  const bool explained =
      best.left_out() < kMuchGross && best.s_mm < kNearlyNoise * readings.rig_noise_mm();
  for (const Hypothesis& each : hypotheses) {
    if (explained || !each.effect->exchanges_dials) continue;
    Readings swapped = readings.with_swapped_dials(each.place.dial, each.place.other_dial);
    JointFit fit = fit_with_mounting(swapped, baseline.model);
    if (fit.log_likelihood <= best_likelihood) continue;
    // An exchange brings the readings of two dials back; one that has to do without more of
    // them than before is none.
    if (fit.left_out() > std::max(kMostLeftOut, left_out_before)) continue;
    best_likelihood = fit.log_likelihood;
    best = std::move(fit);
    best_readings = std::move(swapped);
    found = each;
  }
  if (found) readings = std::move(*best_readings);
  // The robot as it is once the dials may stand elsewhere: with these where the rig file says,
  // a fit from here tells those that do not.
  JointFit again = fit_jointly(readings, best.model, {});
  if (found || again.log_likelihood > baseline.log_likelihood) baseline = std::move(again);
  return found;
}

}  // namespace sixdial::diagnosis
