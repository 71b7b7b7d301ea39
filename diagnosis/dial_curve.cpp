#include "diagnosis/dial_curve.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

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

/// What is told of a curve by its errors; they are known to `variance` mm^2 at worst.
void measure(DialCurve& curve, const Readings& readings, double variance) {
  const auto& rows = readings.rows_of_dial(curve.dial);
  const Eigen::VectorXd own = curve.error_mm(rows);
  // The dial's zero is nobody's: half of the span is what no zero could take away.
  curve.half_span_mm = (own.maxCoeff() - own.minCoeff()) / 2;
  curve.half_span_sd_mm = std::sqrt(variance / 2);
  curve.rms_mm = std::sqrt((own.array() - own.mean()).square().mean());
}

/// `rivals`: smooth functions that would do about as well as number `i` of `found.unknown`.
/// Empty where that function is none of a dial's own reading, or may be within the dial's
/// accuracy_mm.
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
  double variance = 0.0;
  for (const Eigen::Index row : readings.rows_of_dial(*dial)) {
    const auto c = found.fit.random.row(row).segment(first, own);
    curve.error_mm[row] = c.dot(u);
    variance = std::max(variance, c.transpose().cwiseProduct(u_sd).squaredNorm());
  }
  measure(curve, readings, variance);
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

/// Other smooth functions that would do about as well as number i that was chosen.
std::vector<UnknownCandidate> rivals_of_unknown(
    const Readings& readings, const Search& search, const Explanation& found, std::size_t i) {
  std::vector<UnknownCandidate> result;
  const Explanation less = search.without_unknown(found, i);
  const auto same = [&](const UnknownCandidate& each) {
    return each.covariates == found.unknown[i].covariates &&
           each.enters == found.unknown[i].enters;
  };
  auto rivals = score_unknown(readings, less.fit);
  const auto own = std::find_if(rivals.begin(), rivals.end(), same);
  if (own == rivals.end()) return result;
  const double least = own->evidence - kUnknownTie;
  for (UnknownCandidate& rival : rivals) {
    if (!same(rival) && !rival.is_background() && rival.evidence > least)
      result.push_back(std::move(rival));
  }
  return result;
}

/// Two smooth functions of one dial's reading are one curve.
void add(std::vector<DialCurve>& curves, DialCurve curve, const Readings& readings) {
  const auto same = std::ranges::find(curves, curve.dial, &DialCurve::dial);
  if (same == curves.end()) {
    curves.push_back(std::move(curve));
    return;
  }
  const auto variance = [](const DialCurve& of) {
    return 2 * of.half_span_sd_mm * of.half_span_sd_mm;
  };
  same->error_mm += curve.error_mm;
  measure(*same, readings, variance(*same) + variance(curve));
  same->smooth.columns = random_columns(readings.count(), {same->smooth, curve.smooth});
  same->evidence += curve.evidence;
  std::ranges::move(curve.tied_with, std::back_inserter(same->tied_with));
}

}  // namespace

void tell_smooth_apart(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, NamedCauses& result) {
  for (std::size_t i = 0; i < found.unknown.size(); ++i) {
    const UnknownCandidate& each = found.unknown[i];
    if (each.is_background()) {
      result.background.push_back(each);
      continue;
    }
    auto rivals = rivals_of_unknown(readings, search, found, i);
    if (auto curve = dial_curve_of(readings, search, settings, found, i, rivals)) {
      add(result.dial_curves, std::move(*curve), readings);
      continue;
    }
    result.unknown.push_back(each);
    std::ranges::move(rivals, std::back_inserter(result.unknown_rivals));
  }
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
