#include "diagnosis/dial_curve.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/covariate.h"

namespace sixdial::diagnosis {
namespace {

/// The dial whose own reading a smooth function goes by; empty: another kind of function.
std::optional<std::size_t> dial_of(const Readings& readings, const UnknownCandidate& smooth) {
  if (smooth.kind != UnknownKind::kSmooth || !readings.has_dials()) return std::nullopt;
  const auto& dials = readings.model().rig().dials;
  for (std::size_t d = 0; d < dials.size(); ++d) {
    const std::string own = dependence_name({.on = DependsOn::kReading, .dial = dials[d].id});
    const std::vector<std::string> alone{own};
    if (smooth.enters == "dial " + dials[d].id && smooth.covariates == alone) return d;
  }
  return std::nullopt;
}

}  // namespace

std::optional<DialCurve> dial_curve_of(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, std::size_t i, const std::vector<UnknownCandidate>& rivals) {
  const UnknownCandidate& smooth = found.unknown[i];
  const auto dial = dial_of(readings, smooth);
  if (!dial) return std::nullopt;
  DialCurve curve{.dial = *dial, .smooth = smooth};

  Eigen::Index first = readings.nuisance().cols();
  for (std::size_t k = 0; k < i; ++k) first += found.unknown[k].columns.cols();
  const auto own = smooth.columns.cols();
  const auto u = found.fit.u.segment(first, own);
  const auto u_sd = found.fit.u_sd_mm.segment(first, own);
  curve.error_mm = Eigen::VectorXd::Zero(readings.count());
  double low_mm = 0.0;
  double high_mm = 0.0;
  double mean_mm = 0.0;
  double squares = 0.0;
  double variance = 0.0;
  const auto& rows = readings.rows_of_dial(*dial);
  for (const Eigen::Index row : rows) {
    const auto c = found.fit.random.row(row).segment(first, own);
    const double error_mm = c.dot(u);
    curve.error_mm[row] = error_mm;
    if (row == rows.front()) low_mm = high_mm = error_mm;
    low_mm = std::min(low_mm, error_mm);
    high_mm = std::max(high_mm, error_mm);
    mean_mm += error_mm / static_cast<double>(rows.size());
    squares += error_mm * error_mm / static_cast<double>(rows.size());
    variance = std::max(variance, c.transpose().cwiseProduct(u_sd).squaredNorm());
  }
  // The dial's zero is nobody's: half of the span is what no zero could take away.
  curve.half_span_mm = (high_mm - low_mm) / 2;
  curve.half_span_sd_mm = std::sqrt(variance / 2);
  curve.rms_mm = std::sqrt(std::max(0.0, squares - mean_mm * mean_mm));
  curve.limit_mm = readings.model().rig().dials[*dial].accuracy_mm;
  constexpr double kForSure = 2.0;  // standard deviations
  if (!(curve.half_span_mm - kForSure * curve.half_span_sd_mm > curve.limit_mm)) {
    return std::nullopt;
  }

  const Explanation less = search.without_unknown(found, i);
  curve.evidence = found.evidence - less.evidence;
  if (!rivals.empty()) curve.tied_with_unknown = rivals.front().covariates;
  for (const Explanation& named : search.instead_of_unknown(found, i, less, kTies)) {
    const double odds = found.evidence - named.evidence;
    if (odds >= settings.tie_log_odds) continue;
    curve.tied_with.push_back(
        {named.chosen.back().candidate.hypothesis, named.fit.effects.back(), odds});
  }
  curve.tied_with_nothing = curve.evidence < settings.tie_log_odds;
  curve.settled = found.fit.converged;
  curve.left_out = found.fit.left_out();
  return curve;
}

void doubt_beside_curves(
    const Readings& readings, const Explanation& found, NamedCauses& names) {
  for (const UnknownCandidate& smooth : found.unknown) {
    const auto dial = dial_of(readings, smooth);
    if (!dial) continue;
    for (Finding& finding : names.findings) {
      if (finding.hypothesis.place.dial != static_cast<int>(*dial)) continue;
      if (!finding.tied_with_unknown.empty()) continue;
      finding.tied_with_unknown = smooth.covariates;
      finding.unknown_log_odds = 0.0;  // what has no form of its own can have any part of it
    }
  }
}

}  // namespace sixdial::diagnosis
