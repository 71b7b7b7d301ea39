#include "diagnosis/naming.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "calibration/crew.h"
#include "diagnosis/baseline.h"
#include "diagnosis/covariate.h"
#include "diagnosis/curves_in_model.h"
#include "diagnosis/dials_alone.h"
#include "diagnosis/exchanged_dials.h"
#include "diagnosis/explanation.h"
#include "diagnosis/gross_readings.h"
#include "diagnosis/growing.h"
#include "diagnosis/joint_curve.h"
#include "diagnosis/own_curve.h"
#include "diagnosis/rig_known.h"
#include "diagnosis/shareable.h"
#include "diagnosis/thresholds.h"
#include "diagnosis/tied_sets.h"
#include "diagnosis/uneven_noise.h"

namespace sixdial::diagnosis {
namespace {

/// Beside something smooth: names that it makes needless go, a name takes its place if it can,
/// names that it hid come; until nothing changes.
class Refinement {
 public:
  Refinement(const Search& search, const NamingSettings& settings, Explanation& found)
      : search_(search), settings_(settings), found_(found) {}

  void run() {
    constexpr int kMostRounds = 5;
    for (int round = 0; round < kMostRounds; ++round) {
      const bool less = drop_covered();
      const bool needless = drop_needless();
      const bool named = name_unknown();
      const bool more = add_hidden();
      if (!less && !needless && !named && !more) return;
    }
    drop_needless();
  }

 private:
  /// What a name must show here. Something that wanders in time makes steps and drifts of its
  /// own, at every scale.
  [[nodiscard]] double needed(const Hypothesis& name) const {
    if (found_.unknown_findings() == 0) return settings_.least_log_odds;
    for (const UnknownCandidate& each : found_.unknown) {
      if (each.kind == UnknownKind::kRigGeometry && name.effect->of_rig_geometry) return kNever;
      const bool wanders = each.length < 0 && each.covariates.front() == "time";
      if (wanders && name.effect->in_time) return settings_.beside_wandering_log_odds;
    }
    return settings_.beside_unknown_log_odds;
  }

  /// Without a name the smooth part may do as well, fitted anew.
  bool drop_covered() {
    bool changed = false;
    for (std::size_t i = 0; i < found_.chosen.size();) {
      Explanation names = found_;
      std::erase_if(names.unknown, [](const auto& each) { return !each.is_background(); });
      Explanation less = search_.with_unknown(search_.without(names, i));
      if (less.evidence > found_.evidence - needed(found_.chosen[i].candidate.hypothesis)) {
        found_ = std::move(less);
        changed = true;
        i = 0;
      } else {
        ++i;
      }
    }
    return changed;
  }

  bool drop_needless() {
    bool changed = false;
    for (std::size_t i = 0; i < found_.chosen.size();) {
      Explanation less = search_.without(found_, i);
      if (less.evidence > found_.evidence - needed(found_.chosen[i].candidate.hypothesis)) {
        found_ = std::move(less);
        changed = true;
        i = 0;
      } else {
        ++i;
      }
    }
    return changed;
  }

  bool name_unknown() {
    for (std::size_t i = 0; i < found_.unknown.size(); ++i) {
      if (found_.unknown[i].is_background()) continue;
      const Explanation less = search_.without_unknown(found_, i);
      auto named = search_.instead_of_unknown(found_, i, less, kNamesForUnknown);
      if (named.empty() || named.front().evidence <= found_.evidence) continue;
      found_ = search_.with_unknown(named.front());
      return true;
    }
    return false;
  }

  bool add_hidden() {
    if (static_cast<int>(found_.chosen.size()) >= settings_.most_causes) return false;
    const auto candidates = search_.scored(found_);
    if (family_p_value(candidates) > settings_.false_alarm_level) return false;
    auto choices = search_.with_one_more(found_, candidates, kBetterRivals);
    if (choices.empty()) return false;
    const double least = needed(choices.front().chosen.back().candidate.hypothesis);
    if (choices.front().evidence <= found_.evidence + least) return false;
    found_ = std::move(choices.front());
    return true;
  }

  const Search& search_;
  const NamingSettings& settings_;
  Explanation& found_;
};

/// Leaves out names that the explanation is as good without: a fit with something on top may
/// have found the way to a better one without it.
void drop_needless(const Search& search, const NamingSettings& settings, Explanation& found) {
  for (std::size_t i = 0; i < found.chosen.size();) {
    Explanation less = search.without(found, i);
    if (less.evidence > found.evidence - settings.least_log_odds) {
      found = std::move(less);
      i = 0;
    } else {
      ++i;
    }
  }
}

/// A name has to explain clearly more than the same computed from a wrong quantity.
void hold_against_sham(
    const Search& search, const NamingSettings& settings, const Explanation& less,
    Finding& finding) {
  const simulation::Effect& effect = *finding.hypothesis.effect;
  if (effect.sham == nullptr) return;
  const auto evidence = [&](const simulation::Effect& which) {
    const std::vector<Candidate> found =
        score_all(search.readings(), less.fit, {{&which, finding.hypothesis.place}});
    return found.empty() ? 0.0 : std::max(0.0, found.front().evidence);
  };
  const double odds = evidence(effect) - evidence(*effect.sham);
  if (odds >= settings.tie_log_odds || !finding.tied_with_unknown.empty()) return;
  finding.tied_with_unknown = {
      dependence_name({.on = DependsOn::kJointAngle, .joint = finding.hypothesis.place.joint})};
  finding.unknown_log_odds = odds;
}

/// Name number i with its evidence and all that would do about as well in its place.
Finding finding_of(
    const Search& search, const NamingSettings& settings, const Explanation& found,
    std::size_t i) {
  const Explanation bare = search.without(found, i);
  const Explanation less = search.without_for_dials(found, i);
  const double evidence = found.evidence - less.evidence;
  const bool dials = stands_in(found, less) != nullptr;
  Finding finding{
      found.chosen[i].candidate.hypothesis,
      found.fit.effects[i],
      evidence,
      {},
      !dials && evidence < settings.tie_log_odds};
  if (dials && evidence < settings.tie_log_odds) {
    finding.tied_with_unknown = stands_in(found, less)->covariates;
    finding.unknown_log_odds = evidence;
  }
  finding.settled = found.fit.converged;
  finding.left_out = found.fit.left_out();
  // With several names, best_of_growing has already held smooth functions against them; a
  // single name is held against one here.
  const Explanation unnamed =
      found.chosen.size() == 1 ? search.with_unknown(less) : Explanation{};
  if (unnamed.unknown_findings() > found.unknown_findings() &&
      found.evidence - unnamed.evidence < settings.tie_log_odds) {
    finding.tied_with_unknown = unnamed.unknown.back().covariates;
    finding.unknown_log_odds = found.evidence - unnamed.evidence;
  }
  // Without this one the others may need sizes that cannot be: then the likelihoods are
  // compared.
  if (finding.evidence > kNever / 2) {
    finding.evidence = found.fit.log_likelihood - less.fit.log_likelihood;
  }
  hold_against_sham(search, settings, bare, finding);
  // A rival may do without what the dials do in the name's place, or need it.
  std::vector<Explanation> rivals = search.instead_of(found, i, bare, kTies);
  if (dials)
    std::ranges::move(search.instead_of(found, i, less, kTies), std::back_inserter(rivals));
  for (const Explanation& rival : rivals) {
    const Hypothesis& other = rival.chosen.back().candidate.hypothesis;
    const double odds = found.evidence - rival.evidence;
    if (other == finding.hypothesis || odds >= settings.tie_log_odds) continue;
    const auto known = std::ranges::find(
        finding.tied_with, other, [](const Rival& each) { return each.hypothesis; });
    if (known == finding.tied_with.end()) {
      finding.tied_with.push_back({other, rival.fit.effects.back(), odds});
    } else if (odds < known->log_odds) {
      *known = {other, rival.fit.effects.back(), odds};
    }
  }
  return finding;
}

/// What is smooth and in no column looks like several names at once: a slow change like growth
/// by a temperature that rises as well, a drift, a step where these do not fit; a dial's curve
/// like a scale, a shift and a wave. All such names together are held against something smooth
/// that nobody named. What the smooth explanation lacks in evidence, and what it depends on;
/// empty if it took their place, or if they are fewer than two, which finding_of asks by
/// themselves.
struct SmoothRival {
  double log_odds = 0.0;
  std::vector<std::string> covariates;
};
using TakesName = std::function<bool(const Hypothesis&)>;
/// Names that are held together.
struct KindOfNames {
  TakesName takes;
  std::string covariate{};  // that the smooth function must have; empty: any
  double given_back = 0.0;  // of the preference for names, where that function is a name too
};
std::optional<SmoothRival> hold_together(
    const Search& search, Explanation& found, const KindOfNames& kind) {
  Explanation others = found;
  std::erase_if(others.unknown, [](const auto& each) { return !each.is_background(); });
  for (std::size_t i = others.chosen.size(); i-- > 0;) {
    if (kind.takes(others.chosen[i].candidate.hypothesis)) others = search.without(others, i);
  }
  if (others.chosen.size() + 1 >= found.chosen.size()) return std::nullopt;
  Explanation smooth = search.with_unknown(others);
  if (smooth.unknown_findings() == 0) return std::nullopt;
  const auto of_kind = std::ranges::find_if(smooth.unknown, [&](const auto& each) {
    return !each.is_background() &&
           (kind.covariate.empty() || each.covariates == std::vector{kind.covariate});
  });
  if (of_kind == smooth.unknown.end()) return std::nullopt;
  if (smooth.evidence > found.evidence) {
    found = std::move(smooth);
    return std::nullopt;
  }
  return SmoothRival{found.evidence - smooth.evidence - kind.given_back, of_kind->covariates};
}

bool is_slow(const Hypothesis& name) {
  constexpr unsigned kSlow = simulation::kTime | simulation::kTemperature;
  return name.effect->in_time || (name.effect->needs & kSlow) != 0;
}

/// Slow changes, and the names of each dial: its curve is a name too.
std::vector<KindOfNames> kinds_of_names(
    const Readings& readings, const NamingSettings& settings) {
  std::vector<KindOfNames> kinds{{is_slow}};
  const auto& rig = readings.model().rig();
  const std::size_t dials = readings.has_dials() ? rig.dials.size() : 0;
  for (std::size_t d = 0; d < dials; ++d) {
    const auto takes = [d](const Hypothesis& name) {
      return name.place.dial == static_cast<int>(d) && !name.effect->is_step;
    };
    const std::string own =
        dependence_name({.on = DependsOn::kReading, .dial = rig.dials[d].id});
    kinds.push_back({takes, own, settings.name_preference});
  }
  return kinds;
}

/// Where something smooth was needed, and more than noise is left all the same, the readings
/// hold a structure that neither names nor smooth functions describe: each name may be a part
/// of it.
void doubt_beside_structure(
    const Readings& readings, const Explanation& found, NamedCauses& result) {
  const bool described = found.fit.s_mm < kMakersWord * readings.rig_noise_mm();
  // Unequal masses come with the name of a weight, and are no structure that lacks one.
  const auto smooth = std::ranges::find_if(found.unknown, [](const UnknownCandidate& each) {
    return each.kind != UnknownKind::kMasses;
  });
  if (smooth == found.unknown.end() || described) return;
  const auto doubt = [&](auto& each) {
    if (!each.tied_with_unknown.empty()) return;
    each.tied_with_unknown = smooth->covariates;
    each.unknown_log_odds = 0.0;  // nobody can weigh what has no description
  };
  std::ranges::for_each(result.findings, doubt);
  std::ranges::for_each(result.dial_curves, doubt);
  std::ranges::for_each(result.joint_curves, doubt);
}

/// With the noise of each dial taken as given.
NamedCauses name_causes_with_noise(Readings& readings, const NamingSettings& settings) {
  NamedCauses result;
  result.baseline = fit_baseline(readings);
  readings.place_tool(result.baseline.model);
  const std::vector<Hypothesis> hypotheses = hypotheses_for(readings, result.not_testable);
  result.swap = find_exchanged_dials(readings, hypotheses, result.baseline);
  readings.place_tool(result.baseline.model);
  readings.share(shareable_columns(readings, result.baseline.model));
  result.baseline = fit_jointly(readings, result.baseline.model, {}, &result.baseline);
  const Search search(readings, settings, hypotheses);

  Explanation found = best_of_growing(search, settings, result);
  if (const UnknownCandidate* rig = rig_of(found)) {  // name_causes_on_this_rig asks again
    result.unknown = {*rig};
    return result;
  }
  if (found.unknown_findings() == 0) {
    drop_needless(search, settings, found);
  } else {
    Refinement(search, settings, found).run();
  }
  hold_against_dials(search, settings, found);
  auto exchanges = search.exchange_twos(found);
  const std::size_t names = found.chosen.size();
  std::vector<std::pair<TakesName, SmoothRival>> smooth_rivals;
  for (const KindOfNames& kind : kinds_of_names(readings, settings)) {
    if (auto rival = hold_together(search, found, kind)) {
      smooth_rivals.emplace_back(kind.takes, std::move(*rival));
    }
  }
  if (found.chosen.size() != names) exchanges = search.exchange_twos(found);
  tell_smooth_apart(readings, search, settings, found, result);
  result.findings.resize(found.chosen.size());
  calibration::in_parallel(static_cast<int>(found.chosen.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    result.findings[k] = finding_of(search, settings, found, k);
  });
  tie_alike_sets(readings, search, settings, found, exchanges, result.findings);
  for (const auto& [takes, smooth] : smooth_rivals) {
    if (smooth.log_odds >= settings.tie_log_odds) continue;
    for (Finding& finding : result.findings) {
      if (!takes(finding.hypothesis)) continue;
      finding.tied_with_unknown = smooth.covariates;
      finding.unknown_log_odds = smooth.log_odds;
    }
  }
  doubt_beside_structure(readings, found, result);
  doubt_beside_curves(readings, found, result);
  result.gross = gross_readings(readings, found.fit);
  result.evidence = found.evidence;
  result.extended = std::move(found.fit);
  return result;
}

/// What the names would be worth on a rig that is exactly as its file says, less what they are
/// worth where it is open: below 0, the opening is needed.
double log_odds_of_exactness(
    const Readings& claimed, const NamedCauses& opened, const NamingSettings& settings) {
  const JointFit& with = opened.extended;
  const JointFit without = fit_jointly(
      claimed, with.model, with.effects, &with, opened.own_columns(claimed.count()));
  return without.log_likelihood - with.log_likelihood + settings.name_preference;
}

/// Where the rig file claims more than holds: asks again with as much of it open as shows, so
/// that no name has to stand for it. Where the names that come out then do without, it holds.
NamedCauses name_causes_on_this_rig(Readings& readings, const NamingSettings& settings) {
  const Readings before = readings;
  NamedCauses result = name_causes_with_noise(readings, settings);
  if (result.unknown.empty() || result.unknown.front().kind != UnknownKind::kRigGeometry) {
    return result;
  }
  const UnknownCandidate rig = result.unknown.front();
  readings = before.allowing_rig(rig.scale);
  NamedCauses opened = name_causes_with_noise(readings, settings);
  Readings claimed = before.allowing_rig(0.0);
  claimed.place_tool(opened.extended.model);
  claimed.share(readings.shareable());
  const double odds = log_odds_of_exactness(claimed, opened, settings);
  if (odds >= 0.0) {
    readings = before.allowing_rig(0.0);
    return name_causes_with_noise(readings, settings);
  }
  opened.rig_geometry = -odds;
  RigKnown known = rig_known(readings, opened.extended);
  readings = readings.allowing_rig_by(std::move(known.of_a_workshop));
  opened.extended = std::move(known.fit);
  opened.baseline = fit_jointly(readings, opened.baseline.model, {}, &opened.baseline);
  opened.gross = gross_readings(readings, opened.extended);
  return opened;
}

/// Asks again with the noise that each dial shows, until it stays: a dial that scatters more
/// than the others would make causes of its own. Its tails come in step by step.
NamedCauses identify_from(
    Readings& readings, const Readings& as_measured, const NamingSettings& settings) {
  NamedCauses result = name_causes_on_this_rig(readings, settings);
  constexpr int kMostPasses = 3;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    std::vector<double> noise = uneven_noise(readings, result.extended);
    if (noise.empty()) break;
    if (result.swap) {  // known under the names that the rig file gives
      std::swap(
          noise[static_cast<std::size_t>(result.swap->place.dial)],
          noise[static_cast<std::size_t>(result.swap->place.other_dial)]);
    }
    readings = as_measured.with_noise(std::move(noise));
    result = name_causes_on_this_rig(readings, settings);
  }
  return result;
}

NamedCauses name_causes_of_joints_as_read(Readings& readings, const NamingSettings& settings) {
  const Readings as_measured = readings;
  const JointFit plain = fit_baseline(readings);
  NamedCauses result = identify_from(readings, as_measured, settings);
  // A noisy dial looks like a cause at that dial, which then leaves no noise to be seen. Both
  // are tried: the noise first, or the names first.
  const bool curves = !result.dial_curves.empty() || !result.joint_curves.empty();
  if (result.findings.empty() && result.unknown.empty() && !curves) {
    return result;
  }
  // Names that leave nothing but the noise that the rig file says, alike at all dials: a noise
  // of one dial would have had to be left.
  const bool nothing_left = result.unknown.empty() &&
                            readings.noise_of_dial() == as_measured.noise_of_dial() &&
                            result.extended.s_mm < kMakersWord * readings.rig_noise_mm();
  if (nothing_left) return result;
  std::vector<double> noise = uneven_noise(as_measured, plain);
  if (noise.empty() || result.swap) return result;
  Readings noise_first = as_measured.with_noise(std::move(noise));
  NamedCauses other = identify_from(noise_first, as_measured, settings);
  if (other.evidence - noise_cost(noise_first) > result.evidence - noise_cost(readings)) {
    readings = std::move(noise_first);
    return other;
  }
  return result;
}

}  // namespace

NamedCauses name_causes(Readings& readings, const NamingSettings& settings) {
  std::vector<JointCurve> curves = find_joint_curves(readings, settings);
  if (curves.empty()) return name_causes_of_joints_as_read(readings, settings);
  const JointFit plain = fit_baseline(readings);
  const JointFit bent = with_curves(readings, plain, {curves.begin(), curves.end()});
  readings = readings.with_joints_bent(bent.effects);
  NamedCauses result = name_causes_of_joints_as_read(readings, settings);
  result.baseline = plain;
  result.joint_curves = std::move(curves);
  result.joints_set_right = true;
  return result;
}

}  // namespace sixdial::diagnosis
