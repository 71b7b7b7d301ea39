#include "diagnosis/own_curve.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "diagnosis/covariate.h"
#include "diagnosis/curves_in_model.h"
#include "diagnosis/kernel_basis.h"
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

/// Places of one smooth function's columns among the random ones of the fit.
std::pair<Eigen::Index, Eigen::Index> place_of_columns(
    const Readings& readings, const Explanation& found, std::size_t i) {
  Eigen::Index first = readings.nuisance().cols();
  for (std::size_t k = 0; k < i; ++k) first += found.unknown[k].columns.cols();
  return {first, found.unknown[i].columns.cols()};
}

/// Half of what lies between the lowest and the highest of `error`, by the rows that are good.
void measure_span(
    const Explanation& found, const std::vector<Eigen::Index>& rows,
    const Eigen::VectorXd& error, const Eigen::VectorXd& variance, OwnCurve& curve) {
  std::optional<Eigen::Index> low;
  std::optional<Eigen::Index> high;
  for (const Eigen::Index row : rows) {
    if (!(found.fit.weight[row] > kGoodWeight)) continue;
    if (!low || error[row] < error[*low]) low = row;
    if (!high || error[row] > error[*high]) high = row;
  }
  if (!low || !high) return;
  curve.half_span = (error[*high] - error[*low]) / 2;
  curve.half_span_sd = (std::sqrt(variance[*high]) + std::sqrt(variance[*low])) / 2;
  const Eigen::VectorXd own = error(rows);
  curve.rms = std::sqrt((own.array() - own.mean()).square().mean());
}

/// The error of each reading by the smooth functions `group` of one dial, and how wide it is.
DialCurve curve_of_dial(
    const Readings& readings, const Explanation& found, std::size_t dial,
    const std::vector<std::size_t>& group) {
  const auto& rows = readings.rows_of_dial(dial);
  DialCurve curve;
  curve.effect = curve_of_dials();
  curve.place = simulation::at_each_dial(readings.model().rig()).at(dial);
  curve.dial = dial;
  curve.smooth = found.unknown[group.front()];
  curve.limit_mm = readings.model().rig().dials[dial].accuracy_mm;
  curve.in_readings_mm = Eigen::VectorXd::Zero(readings.count());
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(readings.count());
  for (const std::size_t i : group) {
    curve.parts.push_back(found.unknown[i]);
    const auto [first, own] = place_of_columns(readings, found, i);
    const auto u = found.fit.u.segment(first, own);
    const auto u_sd = found.fit.u_sd_mm.segment(first, own);
    for (const Eigen::Index row : rows) {
      const Eigen::VectorXd c = found.fit.random.row(row).segment(first, own);
      curve.in_readings_mm[row] += c.dot(u);
      variance[row] += c.cwiseProduct(u_sd).squaredNorm();
    }
  }
  curve.smooth.columns = random_columns(readings.count(), curve.parts);
  // The dial's zero is nobody's: half of the span is what no zero could take away. Both ends
  // may be off in opposite directions.
  measure_span(found, rows, curve.in_readings_mm, variance, curve);
  return curve;
}

constexpr double kForSure = 2.0;  // standard deviations

bool is_for_sure_beyond_limit(const DialCurve& curve) {
  return curve.half_span - kForSure * curve.half_span_sd > curve.limit_mm;
}

/// The joint whose own value a smooth function goes by and bends; empty: another kind.
std::optional<simulation::Place> joint_of(
    const Readings& readings, const UnknownCandidate& smooth) {
  if (smooth.kind != UnknownKind::kSmooth || smooth.kernel.functions.empty()) {
    return std::nullopt;
  }
  for (simulation::Place& place : simulation::at_each_joint(readings.model().rig())) {
    const std::string own =
        dependence_name({.on = DependsOn::kJointAngle, .joint = place.joint});
    if (smooth.enters == place.name && smooth.covariates == std::vector{own}) return place;
  }
  return std::nullopt;
}

/// Evidence, and all that would do about as well.
void weigh(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, const std::vector<std::size_t>& group, OwnCurve& curve) {
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

/// Frequency, in radians a half range, at which a wave is strongest: sines of a box lie coarse
/// beside each other. Empty where that is no peak near its sine.
std::optional<double> strongest_frequency(const Kernel& kernel, const Eigen::VectorXd& u) {
  constexpr int kPoints = 4000;
  constexpr int kSteps = 120;     // to either side
  constexpr double kReach = 3.0;  // sines
  const int sine = kernel.wave;
  const double apart = std::numbers::pi / (2 * kernel.half_width);
  const double high = (kernel.high - kernel.low) / 2;
  Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(kPoints, -1.0, 1.0);
  const Eigen::VectorXd value = at.unaryExpr([&](double each) {
    // Fading out at the ends, else a wave shows beside its own frequency too.
    const double fade = std::cos(std::numbers::pi / 2 * each);
    return fade * fade * kernel_values(kernel, kernel.low + (1 + each) * high).dot(u);
  });
  double best = 0.0;
  int at_step = 0;
  std::optional<double> frequency;
  for (int step = -kSteps; step <= kSteps; ++step) {
    const double tried = (sine + 1 + kReach * step / kSteps) * apart;
    const double power = std::hypot(
        value.dot((tried * at.array()).cos().matrix()),
        value.dot((tried * at.array()).sin().matrix()));
    if (power <= best || !(tried > 0.0)) continue;
    best = power;
    at_step = step;
    frequency = tried;
  }
  return std::abs(at_step) < kSteps ? frequency : std::nullopt;
}

/// Length of the wave that is the strongest of these smooth functions, in their covariate's
/// unit; empty where another function is, that has no wave length of its own.
std::optional<double> strongest_period(
    const Explanation& found, const Readings& readings, const std::vector<std::size_t>& group) {
  double strongest = 0.0;
  std::optional<double> period;
  for (const std::size_t i : group) {
    const Kernel& kernel = found.unknown[i].kernel;
    const auto [first, own] = place_of_columns(readings, found, i);
    const Eigen::VectorXd u = found.fit.u.segment(first, own);
    const double size =
        kernel.size.cwiseProduct(u).cwiseAbs().maxCoeff() / std::sqrt(kernel.half_width);
    if (size <= strongest) continue;
    strongest = size;
    period.reset();
    if (kernel.wave < 0) continue;
    const auto frequency = strongest_frequency(kernel, u);
    if (frequency) period = std::numbers::pi * kernel.range() / *frequency;
  }
  return period;
}

/// A part of a smooth function of the dial's reading: neither a jump in time nor what goes by
/// the direction of the plunger.
bool may_be_part_of_curve(const simulation::Effect& effect) {
  return !effect.is_step && effect.plot.groups != simulation::Groups::kPlungerDirection;
}

}  // namespace

bool is_for_sure(const JointCurve& curve) {
  return curve.half_span > kForSure * curve.half_span_sd;
}

void hold_against_sham(
    const Readings& readings, const JointFit& without, const NamingSettings& settings,
    JointCurve& curve) {
  std::vector<std::string> best_sham;
  for (const UnknownCandidate& each :
       score_joint_by_others(readings, without, curve.place.joint)) {
    if (each.covariates == curve.smooth.covariates) {
      curve.own_evidence = std::max(curve.own_evidence, each.evidence);
    } else if (each.evidence > curve.sham_evidence) {
      curve.sham_evidence = each.evidence;
      best_sham = each.covariates;
    }
  }
  const double odds = curve.own_evidence - curve.sham_evidence;
  if (best_sham.empty() || odds >= settings.tie_log_odds) return;
  if (!curve.tied_with_unknown.empty()) return;
  curve.tied_with_unknown = best_sham;
  curve.unknown_log_odds = odds;
}

JointCurve curve_of_joint(
    const Readings& readings, const Explanation& found, const simulation::Place& place,
    const std::vector<std::size_t>& group) {
  JointCurve curve;
  curve.effect = simulation::curve_of_joints();
  curve.place = place;
  curve.smooth = found.unknown[group.front()];
  curve.in_readings_mm = Eigen::VectorXd::Zero(readings.count());
  Eigen::VectorXd error = Eigen::VectorXd::Zero(readings.count());
  Eigen::VectorXd variance = error;
  for (const std::size_t i : group) {
    const UnknownCandidate& part = found.unknown[i];
    curve.parts.push_back(part);
    const auto [first, own] = place_of_columns(readings, found, i);
    const Eigen::VectorXd u = found.fit.u.segment(first, own);
    const Eigen::VectorXd u_sd = found.fit.u_sd_mm.segment(first, own);
    curve.in_readings_mm += found.fit.random.middleCols(first, own) * u;
    for (Eigen::Index row = 0; row < readings.count(); ++row) {
      const auto trial =
          static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].trial);
      const Eigen::VectorXd basis =
          kernel_values(part.kernel, readings.trials()[trial].q[place.joint]);
      error[row] += basis.dot(u);
      variance[row] += basis.cwiseProduct(u_sd).squaredNorm();
    }
  }
  curve.period = strongest_period(found, readings, group);
  curve.smooth.columns = random_columns(readings.count(), curve.parts);
  std::vector<Eigen::Index> all(static_cast<std::size_t>(readings.count()));
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  measure_span(found, all, error, variance, curve);
  return curve;
}

void tell_smooth_apart(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, NamedCauses& result) {
  std::map<std::size_t, std::vector<std::size_t>> of_dial;
  std::map<int, std::pair<simulation::Place, std::vector<std::size_t>>> of_joint;
  for (std::size_t i = 0; i < found.unknown.size(); ++i) {
    if (const auto dial = dial_of(readings, found.unknown[i])) of_dial[*dial].push_back(i);
    if (const auto place = joint_of(readings, found.unknown[i])) {
      auto& [where, group] = of_joint[place->joint];
      where = *place;
      group.push_back(i);
    }
  }
  std::set<std::size_t> named;
  for (const auto& [dial, group] : of_dial) {
    DialCurve curve = curve_of_dial(readings, found, dial, group);
    if (!is_for_sure_beyond_limit(curve)) continue;
    weigh(readings, search, settings, found, group, curve);
    result.dial_curves.push_back(std::move(curve));
    named.insert(group.begin(), group.end());
  }
  for (const auto& [joint, place_and_group] : of_joint) {
    const auto& [place, group] = place_and_group;
    JointCurve curve = curve_of_joint(readings, found, place, group);
    if (!is_for_sure(curve)) continue;
    weigh(readings, search, settings, found, group, curve);
    hold_against_sham(
        readings, search.without_unknown(found, group.front()).fit, settings, curve);
    result.joint_curves.push_back(std::move(curve));
    named.insert(group.begin(), group.end());
  }
  for (std::size_t i = 0; i < found.unknown.size(); ++i) {
    const UnknownCandidate& each = found.unknown[i];
    if (each.kind == UnknownKind::kMasses) {
      result.masses.push_back(each);
    } else if (each.is_background()) {
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
