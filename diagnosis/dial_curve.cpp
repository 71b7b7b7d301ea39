#include "diagnosis/dial_curve.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "diagnosis/covariate.h"
#include "diagnosis/thresholds.h"

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

/// The rivals of a smooth function, and what the function itself is worth beside them.
struct Rivals {
  double own = 0.0;
  std::vector<UnknownCandidate> others;
};

/// Other smooth functions that would do about as well as number i that was chosen.
Rivals rivals_of_unknown(
    const Readings& readings, const Search& search, const Explanation& found, std::size_t i) {
  Rivals result;
  const Explanation less = search.without_unknown(found, i);
  const auto same = [&](const UnknownCandidate& each) {
    return each.covariates == found.unknown[i].covariates &&
           each.enters == found.unknown[i].enters;
  };
  auto rivals = score_unknown(readings, less.fit);
  const auto own = std::ranges::find_if(rivals, same);
  if (own == rivals.end()) return result;
  result.own = own->evidence;
  for (UnknownCandidate& rival : rivals) {
    if (!same(rival) && !rival.is_background() && rival.evidence > result.own - kUnknownTie)
      result.others.push_back(std::move(rival));
  }
  return result;
}

/// The error of each reading by the smooth functions `group` of one dial, and how wide it is.
DialCurve curve_of(
    const Readings& readings, const Explanation& found, std::size_t dial,
    const std::vector<std::size_t>& group) {
  const auto& rows = readings.rows_of_dial(dial);
  DialCurve curve{.dial = dial, .smooth = found.unknown[group.front()]};
  curve.limit_mm = readings.model().rig().dials[dial].accuracy_mm;
  curve.error_mm = Eigen::VectorXd::Zero(readings.count());
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(readings.count());
  std::vector<UnknownCandidate> parts;
  for (const std::size_t i : group) {
    parts.push_back(found.unknown[i]);
    Eigen::Index first = readings.nuisance().cols();
    for (std::size_t k = 0; k < i; ++k) first += found.unknown[k].columns.cols();
    const Eigen::Index own = found.unknown[i].columns.cols();
    const auto u = found.fit.u.segment(first, own);
    const auto u_sd = found.fit.u_sd_mm.segment(first, own);
    for (const Eigen::Index row : rows) {
      const Eigen::VectorXd c = found.fit.random.row(row).segment(first, own);
      curve.error_mm[row] += c.dot(u);
      variance[row] += c.cwiseProduct(u_sd).squaredNorm();
    }
  }
  curve.smooth.columns = random_columns(readings.count(), parts);

  // The dial's zero is nobody's: half of the span is what no zero could take away. Both ends
  // may be off in opposite directions.
  std::optional<Eigen::Index> low;
  std::optional<Eigen::Index> high;
  for (const Eigen::Index row : rows) {
    if (!(found.fit.weight[row] > kGoodWeight)) continue;
    if (!low || curve.error_mm[row] < curve.error_mm[*low]) low = row;
    if (!high || curve.error_mm[row] > curve.error_mm[*high]) high = row;
  }
  if (!low || !high) return curve;
  curve.half_span_mm = (curve.error_mm[*high] - curve.error_mm[*low]) / 2;
  curve.half_span_sd_mm = (std::sqrt(variance[*high]) + std::sqrt(variance[*low])) / 2;
  const Eigen::VectorXd own = curve.error_mm(rows);
  curve.rms_mm = std::sqrt((own.array() - own.mean()).square().mean());
  return curve;
}

bool is_for_sure_beyond_limit(const DialCurve& curve) {
  constexpr double kForSure = 2.0;  // standard deviations
  return curve.half_span_mm - kForSure * curve.half_span_sd_mm > curve.limit_mm;
}

/// Evidence, and all that would do about as well.
void weigh(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, const std::vector<std::size_t>& group, DialCurve& curve) {
  Explanation without = found;
  for (std::size_t k = group.size(); k-- > 0;) {
    without = search.without_unknown(without, group[k]);
  }
  curve.evidence = found.evidence - without.evidence;
  curve.tied_with_nothing = curve.evidence < settings.tie_log_odds;
  for (const std::size_t i : group) {
    const Rivals rivals = rivals_of_unknown(readings, search, found, i);
    for (const UnknownCandidate& each : rivals.others) {
      const double odds = rivals.own - each.evidence;
      const bool nearer = curve.tied_with_unknown.empty() || odds < curve.unknown_log_odds;
      if (odds >= settings.tie_log_odds || !nearer) continue;
      curve.tied_with_unknown = each.covariates;
      curve.unknown_log_odds = odds;
    }
    const Explanation less = search.without_unknown(found, i);
    for (const Explanation& named : search.instead_of_unknown(found, i, less, kTies)) {
      const double odds = found.evidence - named.evidence;
      if (odds >= settings.tie_log_odds) continue;
      curve.tied_with.push_back(
          {named.chosen.back().candidate.hypothesis, named.fit.effects.back(), odds});
    }
  }
  curve.settled = found.fit.converged;
  curve.left_out = found.fit.left_out();
}

/// A part of a smooth function of the dial's reading: neither a jump in time nor what goes by
/// the direction of the plunger.
bool may_be_part_of_curve(const simulation::Effect& effect) {
  return !effect.is_step && effect.plot.groups != simulation::Groups::kPlungerDirection;
}

}  // namespace

void tell_smooth_apart(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, NamedCauses& result) {
  std::map<std::size_t, std::vector<std::size_t>> of_dial;
  for (std::size_t i = 0; i < found.unknown.size(); ++i) {
    if (const auto dial = dial_of(readings, found.unknown[i])) of_dial[*dial].push_back(i);
  }
  std::set<std::size_t> named;
  for (const auto& [dial, group] : of_dial) {
    DialCurve curve = curve_of(readings, found, dial, group);
    if (!is_for_sure_beyond_limit(curve)) continue;
    weigh(readings, search, settings, found, group, curve);
    result.dial_curves.push_back(std::move(curve));
    named.insert(group.begin(), group.end());
  }
  for (std::size_t i = 0; i < found.unknown.size(); ++i) {
    const UnknownCandidate& each = found.unknown[i];
    if (each.is_background()) {
      result.background.push_back(each);
    } else if (!named.contains(i)) {
      result.unknown.push_back(each);
      Rivals rivals = rivals_of_unknown(readings, search, found, i);
      std::ranges::move(rivals.others, std::back_inserter(result.unknown_rivals));
    }
  }
}

void doubt_beside_curves(
    const Readings& readings, const Explanation& found, NamedCauses& names) {
  for (const UnknownCandidate& smooth : found.unknown) {
    const auto dial = dial_of(readings, smooth);
    if (!dial) continue;
    for (Finding& finding : names.findings) {
      if (finding.hypothesis.place.dial != static_cast<int>(*dial)) continue;
      if (!may_be_part_of_curve(*finding.hypothesis.effect)) continue;
      if (!finding.tied_with_unknown.empty()) continue;
      finding.tied_with_unknown = smooth.covariates;
      finding.unknown_log_odds = 0.0;  // what has no form of its own can have any part of it
    }
  }
}

}  // namespace sixdial::diagnosis
