#include "diagnosis/explanation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "calibration/crew.h"
#include "diagnosis/possible_sizes.h"
#include "diagnosis/thresholds.h"
#include "simulation/weight.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

/// What the search over a period or a sample costs, and its parameters.
double cost_of(const Candidate& candidate) { return candidate.gain - candidate.evidence; }
/// Of so many places and causes just this one: the prior that each further name must overcome.
double prior_cost(std::size_t hypotheses) {
  return std::log(static_cast<double>(std::max<std::size_t>(2, hypotheses)));
}

/// Sizes far beyond what rigs of this kind show are less believable: a Cauchy density, so that
/// no effect is refused for its size: somebody may have typed 57 for 75. But a share of a half
/// or more takes away what it is a share of, which explains anything that always reads zero.
double implausibility(const ActiveEffect& active) {
  double sum = 0.0;
  for (int i = 0; i < linear_count(*active.effect); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto parameter = parameter_at(*active.effect, active.place, i);
    constexpr double kMostShare = 0.5;
    if (parameter && parameter->unit == "1" && std::abs(active.x[k]) >= kMostShare) {
      return kNever;
    }
    if (parameter) sum += std::pow(active.x[k] / (kBelievedWidth * parameter->sigma), 2);
  }
  return std::isfinite(sum) ? std::log1p(sum) : kNever;
}

/// A fit as if its noise were another's: what the readings of an arrival share.
JointFit sharing_like(JointFit fit, const JointFit& other) {
  fit.shared = other.shared;
  fit.shared_ratio = other.shared_ratio;
  if (!fit.shared) fit.shift_mm.setZero();
  return fit;
}

/// Whether columns weigh differently in the two fits.
bool shares_otherwise(const JointFit& a, const JointFit& b) {
  if (a.shared != b.shared) return true;
  constexpr double kAlike = 0.3;  // of the ratio's logarithm: a seventh of a unit of evidence
  return a.shared && std::abs(std::log(a.shared_ratio / b.shared_ratio)) > kAlike;
}

/// Whether a fit without some part calls gross what that part explained: then its weights hide
/// what another name could explain instead.
bool gives_up(const Explanation& less, const Explanation& all) {
  return less.fit.left_out() > all.fit.left_out() + kMuchGross;
}

/// A searched value that the fit moved out of the range of the search.
bool out_of_range(const Readings& readings, const ActiveEffect& active) {
  if (!active.effect->searched || !active.effect->searched_change) return false;
  const std::vector<double> values =
      active.effect->searched(readings.model().rig(), readings.circumstances(), active.place);
  if (values.empty()) return true;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  constexpr double kAtTheEdge = 0.05;
  return active.x.back() < *low * (1 - kAtTheEdge) ||
         active.x.back() > *high * (1 + kAtTheEdge);
}

/// Unequal masses without the name that they belong to would take its place.
bool lacks_its_name(const UnknownCandidate& each, const std::vector<Chosen>& chosen) {
  if (each.kind != UnknownKind::kMasses) return false;
  return std::ranges::none_of(chosen, [&](const Chosen& name) {
    const Hypothesis& own = name.candidate.hypothesis;
    return own.effect == simulation::compliance_under_weight() && own.place.name == each.enters;
  });
}

}  // namespace

std::size_t Explanation::unknown_findings() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      unknown, [](const UnknownCandidate& each) { return !each.is_background(); }));
}

std::vector<Candidate> Search::scored(const Explanation& with) const {
  std::vector<Hypothesis> open;
  for (const Hypothesis& each : hypotheses_) {
    const bool used = std::any_of(
        with.chosen.begin(), with.chosen.end(),
        [&](const Chosen& chosen) { return chosen.candidate.hypothesis == each; });
    if (!used) open.push_back(each);
  }
  return score_all(readings_, with.fit, open);
}

std::vector<Candidate> Search::scored_with_gross(const Explanation& with) const {
  constexpr double kFewest = 3;
  if ((1 - with.fit.weight.array()).sum() < kFewest) return {};
  Explanation all = with;
  all.fit.weight.setOnes();
  std::vector<Candidate> result = scored(all);
  std::erase_if(result, [&](const Candidate& each) {
    return each.evidence < settings_.unknown_log_odds;
  });
  return result;
}

Explanation Search::explained(
    const JointFit& from, std::vector<Chosen> chosen, std::vector<ActiveEffect> sizes,
    std::vector<UnknownCandidate> unknown, bool afresh) const {
  std::erase_if(unknown, [&](const auto& each) { return lacks_its_name(each, chosen); });
  Explanation result{std::move(chosen), std::move(unknown), {}, 0.0};
  const Eigen::MatrixXd random = random_columns(readings_.count(), result.unknown);
  result.fit =
      known_.fit(readings_, from.model, std::move(sizes), afresh ? nullptr : &from, random);
  result.evidence = result.fit.log_likelihood;
  for (const Chosen& each : result.chosen) result.evidence -= each.cost;
  for (std::size_t i = 0; i < result.fit.effects.size(); ++i) {
    const ActiveEffect& each = result.fit.effects[i];
    const bool possible = sizes_are_possible(result.fit, i) && !out_of_range(readings_, each);
    result.evidence -= possible ? implausibility(each) : kNever;
  }
  for (const UnknownCandidate& each : result.unknown) {
    result.evidence -= each.cost + (each.is_background() ? 0.0 : settings_.name_preference);
  }
  return result;
}

Explanation Search::without(const Explanation& all, std::size_t i) const {
  std::vector<Chosen> chosen = all.chosen;
  std::vector<ActiveEffect> sizes = all.fit.effects;
  chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(i));
  sizes.erase(sizes.begin() + static_cast<std::ptrdiff_t>(i));
  return explained(all.fit, std::move(chosen), std::move(sizes), all.unknown);
}

Explanation Search::at_places(
    const Explanation& all, const std::vector<std::size_t>& which,
    const std::vector<Hypothesis>& places) const {
  std::vector<Chosen> chosen = all.chosen;
  std::vector<ActiveEffect> sizes = all.fit.effects;
  for (std::size_t k = 0; k < which.size(); ++k) {
    chosen[which[k]].candidate.hypothesis = places[k];
    sizes[which[k]] = at_rest(places[k]);
    for (std::size_t i = 0; i < all.chosen.size(); ++i) {  // a place that it has already
      if (all.chosen[i].candidate.hypothesis == places[k]) sizes[which[k]] = all.fit.effects[i];
    }
  }
  return explained(all.fit, std::move(chosen), std::move(sizes), all.unknown, true);
}

Explanation Search::without_unknown(const Explanation& all, std::size_t i) const {
  std::vector<UnknownCandidate> unknown = all.unknown;
  unknown.erase(unknown.begin() + static_cast<std::ptrdiff_t>(i));
  return explained(all.fit, all.chosen, all.fit.effects, std::move(unknown));
}

std::vector<Explanation> Search::with_one_more(
    const Explanation& before, const std::vector<Candidate>& candidates, Shortlist list,
    bool afresh) const {
  std::vector<Explanation> result;
  const auto with = [&](const Candidate& candidate) {
    std::vector<Chosen> chosen = before.chosen;
    chosen.push_back({candidate, cost_of(candidate) + prior_cost(hypotheses_.size())});
    std::vector<ActiveEffect> sizes = before.fit.effects;
    sizes.push_back(at_rest(candidate.hypothesis, candidate.searched));
    Explanation found = explained(before.fit, chosen, sizes, before.unknown, afresh);
    const auto linear = static_cast<Eigen::Index>(linear_count(*candidate.hypothesis.effect));
    if (afresh && found.evidence < before.evidence && candidate.sizes.size() == linear) {
      // Something else is gross as well, and draws a fit that counts every reading: from near
      // this name's size the readings that it explains are good, the others stay gross.
      std::ranges::copy(candidate.sizes, sizes.back().x.begin());
      Explanation near =
          explained(before.fit, std::move(chosen), std::move(sizes), before.unknown);
      if (near.evidence > found.evidence) found = std::move(near);
    }
    weigh_last_name(before, found);
    return found;
  };
  const auto add_best_of = [&](const std::vector<Candidate>& scored, std::size_t most) {
    std::vector<const Candidate*> asked;
    std::size_t looked = 0;
    for (const Candidate& candidate : scored) {
      if (looked++ >= most || candidate.evidence < scored.front().evidence - list.within) break;
      const bool known = std::ranges::any_of(result, [&](const Explanation& each) {
        return each.chosen.back().candidate.hypothesis == candidate.hypothesis;
      });
      if (!known) asked.push_back(&candidate);
    }
    std::vector<Explanation> found(asked.size());
    calibration::in_parallel(static_cast<int>(asked.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      found[k] = with(*asked[k]);
    });
    std::ranges::move(found, std::back_inserter(result));
  };
  add_best_of(candidates, list.most);
  if (before.fit.shared && !candidates.empty()) {
    // What passes for a scatter of arrivals may be the cause itself: as if nothing were shared.
    std::vector<Hypothesis> open;
    for (const Candidate& each : candidates) open.push_back(each.hypothesis);
    add_best_of(score_all(readings_, sharing_like(before.fit, {}), open), (list.most + 1) / 2);
  }
  std::stable_sort(
      result.begin(), result.end(),
      [](const Explanation& a, const Explanation& b) { return a.evidence > b.evidence; });
  return result;
}

Explanation Search::without_background(const Explanation& now) const {
  std::vector<UnknownCandidate> unknown = now.unknown;
  std::erase_if(unknown, [](const UnknownCandidate& each) { return each.is_background(); });
  if (unknown.size() == now.unknown.size()) return now;
  return explained(now.fit, now.chosen, now.fit.effects, std::move(unknown));
}

Explanation Search::with_background(Explanation now) const {
  now = without_background(now);
  for (UnknownCandidate& each : score_background(readings_, now.fit)) {
    if (each.evidence <= 0.0) continue;
    std::vector<UnknownCandidate> unknown = now.unknown;
    unknown.push_back(std::move(each));
    Explanation next = explained(now.fit, now.chosen, now.fit.effects, std::move(unknown));
    if (next.evidence > now.evidence) now = std::move(next);
  }
  return now;
}

Explanation Search::without_for_dials(const Explanation& all, std::size_t i) const {
  Explanation less = without(all, i);
  Explanation dials = with_background(less);
  return dials.evidence > less.evidence ? std::move(dials) : std::move(less);
}

std::vector<Explanation> Search::instead_of(
    const Explanation& all, std::size_t i, const Explanation& less, Shortlist list) const {
  if (!gives_up(less, all)) return with_one_more(less, scored(less), list);
  Explanation left = less;
  left.fit = without_effects(all.fit, {i});
  return with_one_more(left, scored(left), list, true);
}

std::vector<Explanation> Search::instead_of_unknown(
    const Explanation& all, std::size_t i, const Explanation& less, Shortlist list) const {
  if (!gives_up(less, all)) return with_one_more(less, scored(less), list);
  Explanation left = less;
  left.fit = all.fit;
  Eigen::Index first = readings_.nuisance().cols();
  for (std::size_t k = 0; k < i; ++k) first += all.unknown[k].columns.cols();
  const Eigen::Index own = all.unknown[i].columns.cols();
  const Eigen::Index after = all.fit.random.cols() - first - own;
  left.fit.residual_mm += all.fit.random.middleCols(first, own) * all.fit.u.segment(first, own);
  left.fit.random.resize(Eigen::NoChange, first + after);
  left.fit.random << all.fit.random.leftCols(first), all.fit.random.rightCols(after);
  left.fit.u.resize(first + after);
  left.fit.u << all.fit.u.head(first), all.fit.u.tail(after);
  return with_one_more(left, scored(left), list, true);
}

void Search::weigh_last_name(const Explanation& before, Explanation& with) const {
  if (!shares_otherwise(before.fit, with.fit)) return;
  Chosen& last = with.chosen.back();
  const auto again =
      score_all(readings_, sharing_like(before.fit, with.fit), {last.candidate.hypothesis});
  if (again.empty()) return;
  const double cost = cost_of(again.front()) + prior_cost(hypotheses_.size());
  with.evidence += last.cost - cost;
  last.cost = cost;
}

Explanation Search::with_unknown(const Explanation& names) const {
  constexpr std::size_t kMostUnknown = 2;
  Explanation best = names;
  while (best.unknown_findings() < kMostUnknown) {
    std::optional<Explanation> next;
    const auto try_best_of = [&](std::vector<UnknownCandidate> candidates) {
      std::erase_if(candidates, [](const auto& each) { return each.is_background(); });
      if (candidates.empty() || candidates.front().evidence <= settings_.unknown_log_odds)
        return;
      std::vector<UnknownCandidate> unknown = best.unknown;
      unknown.push_back(std::move(candidates.front()));
      Explanation tried =
          explained(best.fit, best.chosen, best.fit.effects, std::move(unknown));
      if (!next || tried.evidence > next->evidence) next = std::move(tried);
    };
    try_best_of(score_unknown(readings_, best.fit));
    if (best.fit.shared) {
      // What passes for a scatter of arrivals may be the very thing that is smooth.
      try_best_of(score_unknown(readings_, sharing_like(best.fit, {})));
    }
    if (!next || next->evidence <= best.evidence) break;
    best = std::move(*next);
  }
  return best;
}

Explanation Search::with_stand_in(
    const Explanation& all, const TwoEffects& two, const StandIn& instead) const {
  std::vector<Chosen> chosen;
  std::vector<ActiveEffect> sizes;
  for (std::size_t i = 0; i < all.chosen.size(); ++i) {
    if (i == two[0] || i == two[1]) continue;
    chosen.push_back(all.chosen[i]);
    sizes.push_back(all.fit.effects[i]);
  }
  const std::size_t kept = chosen.size();
  for (const ActiveEffect& each : instead.effects) {
    Candidate candidate;
    candidate.hypothesis = {each.effect, each.place};
    chosen.push_back({std::move(candidate), 0.0});
    sizes.push_back(each);
  }
  Explanation result =
      explained(all.fit, std::move(chosen), std::move(sizes), all.unknown, true);
  for (std::size_t i = kept; i < result.chosen.size(); ++i) {
    result.chosen[i].cost = cost_in(result.fit, i) + prior_cost(hypotheses_.size());
    result.evidence -= result.chosen[i].cost;
  }
  return result;
}

std::vector<Search::Exchange> Search::exchange_twos(Explanation& now) const {
  constexpr int kMostExchanges = 6;
  std::vector<Exchange> result;
  // The first better one, or none.
  const auto better = [&]() -> std::optional<Explanation> {
    result.clear();
    if (now.chosen.size() < 2) return std::nullopt;
    const StandIns stand_ins(readings_, now.fit, hypotheses_);
    for (std::size_t j = 1; j < now.chosen.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        const TwoEffects two{i, j};
        double evidence = now.evidence;
        for (const std::size_t k : two) {
          const Chosen& own = now.chosen[k];
          if (own.candidate.hypothesis.effect->searched) continue;
          evidence += own.cost - cost_in(now.fit, k) - prior_cost(hypotheses_.size());
        }
        for (const StandIn& instead : stand_ins.of(two)) {
          Explanation rival = with_stand_in(now, two, instead);
          const double log_odds = evidence - rival.evidence;
          constexpr double kBetter = 0.1;
          if (log_odds < -kBetter) return rival;
          if (log_odds < settings_.tie_log_odds) {
            result.push_back({two, std::move(rival), log_odds});
          }
        }
      }
    }
    return std::nullopt;
  };
  for (int i = 0; i < kMostExchanges; ++i) {
    std::optional<Explanation> next = better();
    if (!next) break;
    now = std::move(*next);
  }
  return result;
}

void Search::reconsider(Explanation& now) const {
  for (std::size_t i = 0; now.chosen.size() > 1 && i < now.chosen.size(); ++i) {
    const Explanation less = without(now, i);
    auto rivals = instead_of(now, i, less, kBetterRivals);
    if (!rivals.empty() && rivals.front().evidence > now.evidence + 0.1) {
      now = std::move(rivals.front());
      i = 0;
    }
  }
  for (std::size_t i = 0; i < now.chosen.size();) {
    Explanation less = without(now, i);
    if (less.evidence >= now.evidence - settings_.least_log_odds) {
      now = std::move(less);
    } else {
      ++i;
    }
  }
}

}  // namespace sixdial::diagnosis
