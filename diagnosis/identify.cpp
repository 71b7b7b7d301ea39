#include "diagnosis/identify.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

/// What the search over a period or a sample costs, and its parameters.
double cost_of(const Candidate& candidate) { return candidate.gain - candidate.evidence; }
/// Of so many places and causes just this one: the prior that each further name must overcome.
double prior_cost(std::size_t hypotheses) {
  return std::log(static_cast<double>(std::max<std::size_t>(2, hypotheses)));
}

struct Chosen {
  Candidate candidate;
  double cost = 0.0;
};

class Search {
 public:
  Search(Readings& readings, const Settings& settings, std::vector<Hypothesis> hypotheses)
      : readings_(readings), settings_(settings), hypotheses_(std::move(hypotheses)) {}

  [[nodiscard]] std::vector<Candidate> scored(
      const JointFit& fit, const std::vector<Chosen>& with) const {
    std::vector<Hypothesis> open;
    for (const Hypothesis& each : hypotheses_) {
      const bool used = std::any_of(with.begin(), with.end(), [&](const Chosen& chosen) {
        return chosen.candidate.hypothesis == each;
      });
      if (!used) open.push_back(each);
    }
    return score_all(readings_, fit, open);
  }

  [[nodiscard]] JointFit fitted(const JointFit& from, std::vector<ActiveEffect> effects) const {
    return fit_jointly(readings_, from.model, std::move(effects), &from);
  }

  /// Evidence of a fit with its chosen effects, relative to nothing in particular.
  [[nodiscard]] static double evidence(const JointFit& fit, const std::vector<Chosen>& chosen) {
    double cost = 0.0;
    for (const Chosen& each : chosen) cost += each.cost;
    return fit.log_likelihood - cost;
  }

  struct Choice {
    Chosen chosen;
    JointFit fit;
    double evidence = 0.0;
  };
  /// The best candidates refitted jointly with what is there, best first.
  [[nodiscard]] std::vector<Choice> refitted(
      const JointFit& fit, const std::vector<Chosen>& with,
      const std::vector<Candidate>& candidates, double within, std::size_t most) const {
    std::vector<Choice> result;
    for (const Candidate& candidate : candidates) {
      if (result.size() >= most || candidate.evidence < candidates.front().evidence - within) {
        break;
      }
      std::vector<ActiveEffect> effects = fit.effects;
      effects.push_back(at_rest(candidate.hypothesis, candidate.searched));
      Choice choice{
          {candidate, cost_of(candidate) + prior_cost(hypotheses_.size())},
          fitted(fit, std::move(effects)),
          0.0};
      std::vector<Chosen> all = with;
      all.push_back(choice.chosen);
      choice.evidence = evidence(choice.fit, all);
      result.push_back(std::move(choice));
    }
    std::stable_sort(result.begin(), result.end(), [](const Choice& a, const Choice& b) {
      return a.evidence > b.evidence;
    });
    return result;
  }

 private:
  Readings& readings_;
  const Settings& settings_;
  std::vector<Hypothesis> hypotheses_;
};

std::vector<ActiveEffect> without(const std::vector<ActiveEffect>& effects, std::size_t i) {
  std::vector<ActiveEffect> result = effects;
  result.erase(result.begin() + static_cast<std::ptrdiff_t>(i));
  return result;
}
std::vector<Chosen> without(const std::vector<Chosen>& chosen, std::size_t i) {
  std::vector<Chosen> result = chosen;
  result.erase(result.begin() + static_cast<std::ptrdiff_t>(i));
  return result;
}

void list_gross(const Readings& readings, const JointFit& fit, Identification& result) {
  constexpr double kGrossSigma = 5.0;
  const auto& rig = readings.model().rig();
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    if (std::abs(fit.residual_mm[row]) < kGrossSigma * fit.s_mm || fit.weight[row] > 0.5) {
      continue;
    }
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    GrossReading gross{static_cast<int>(row), fit.residual_mm[row], false};
    if (readings.has_dials()) {
      const auto dial = static_cast<std::size_t>(each.dial);
      const double before =
          readings.circumstances()[static_cast<std::size_t>(each.trial)].previous_mm[dial];
      gross.stale =
          std::abs(readings.measured_mm()[row] - before) < 0.51 * rig.dials[dial].resolution_mm;
    }
    result.gross.push_back(gross);
  }
}

/// Exchanged dials: a parameter-free alternative, tried where much of the session is gross or
/// far off. The pair whose exchange explains the session best, if it does so beyond doubt.
std::optional<Hypothesis> find_swap(
    Readings& readings, const std::vector<Hypothesis>& hypotheses, JointFit& baseline) {
  constexpr double kMuchGross = 0.04;
  constexpr double kFarOff = 8.0;
  // Per exchanged reading; what a 25 sigma error costs in the mixture, and more.
  constexpr double kBeyondDoubt = 50.0;
  const double gross = 1.0 - baseline.weight.sum() / static_cast<double>(std::max<Eigen::Index>(
                                                         1, readings.count()));
  if (gross < kMuchGross && baseline.s_mm < kFarOff * readings.rig_noise_mm()) {
    return std::nullopt;
  }
  std::optional<Hypothesis> found;
  std::optional<Readings> best_readings;
  JointFit best = baseline;
  double best_likelihood = baseline.log_likelihood + kBeyondDoubt;
  for (const Hypothesis& each : hypotheses) {
    if (each.effect->cause != "dial_swap") continue;
    Readings swapped = readings.with_swapped_dials(each.place.dial, each.place.other_dial);
    for (const simulation::ModelVector& start : {baseline.model, readings.model().nominal()}) {
      JointFit fit = fit_jointly(swapped, start, {});
      if (fit.log_likelihood <= best_likelihood) continue;
      best_likelihood = fit.log_likelihood;
      best = std::move(fit);
      best_readings = swapped;
      found = each;
    }
  }
  if (found) {
    readings = std::move(*best_readings);
    baseline = std::move(best);
  }
  return found;
}

}  // namespace

Identification identify(Readings& readings, const Settings& settings) {
  Identification result;
  result.baseline = fit_jointly(readings, readings.model().nominal(), {});
  readings.place_tool(result.baseline.model);
  const std::vector<Hypothesis> hypotheses = hypotheses_for(readings, result.not_testable);
  result.swap = find_swap(readings, hypotheses, result.baseline);
  readings.place_tool(result.baseline.model);
  Search search(readings, settings, hypotheses);

  std::vector<Chosen> chosen;
  JointFit fit = result.baseline;
  // How good the first j causes and a smooth remainder would be together.
  struct Cut {
    double evidence;
    std::vector<Chosen> chosen;
    JointFit fit;
    std::optional<UnknownCandidate> unknown;
  };
  std::vector<Cut> cuts;
  const auto cut = [&] {
    auto unknown = score_unknown(readings, fit);
    Cut each{Search::evidence(fit, chosen), chosen, fit, std::nullopt};
    if (!unknown.empty() && unknown.front().evidence > settings.unknown_log_odds) {
      each.evidence += unknown.front().evidence - settings.name_preference;
      each.unknown = std::move(unknown.front());
    }
    cuts.push_back(std::move(each));
  };

  for (int round = 0; round < settings.most_causes; ++round) {
    const auto candidates = search.scored(fit, chosen);
    if (round == 0) {
      result.candidates = candidates;
      result.family_p_value = family_p_value(candidates);
    }
    cut();
    if (family_p_value(candidates) > settings.false_alarm_level) break;
    auto choices = search.refitted(fit, chosen, candidates, 25.0, 8);
    if (choices.empty() || choices.front().evidence <= Search::evidence(fit, chosen)) break;
    chosen.push_back(choices.front().chosen);
    fit = std::move(choices.front().fit);

    // Swap: with a new one in, an earlier choice may have a better rival.
    for (std::size_t i = 0; chosen.size() > 1 && i < chosen.size(); ++i) {
      const JointFit less = search.fitted(fit, without(fit.effects, i));
      const auto others = without(chosen, i);
      auto rivals = search.refitted(less, others, search.scored(less, others), 15.0, 5);
      if (!rivals.empty() && rivals.front().evidence > Search::evidence(fit, chosen) + 0.1) {
        chosen = others;
        chosen.push_back(rivals.front().chosen);
        fit = std::move(rivals.front().fit);
        i = 0;
      }
    }
    // Backward: what no longer pays for itself goes.
    for (std::size_t i = 0; chosen.size() > 1 && i < chosen.size();) {
      JointFit less = search.fitted(fit, without(fit.effects, i));
      const auto others = without(chosen, i);
      if (Search::evidence(less, others) >= Search::evidence(fit, chosen)) {
        chosen = others;
        fit = std::move(less);
      } else {
        ++i;
      }
    }
  }
  if (!cuts.empty() && cuts.back().chosen.size() != chosen.size()) cut();

  const auto best = std::max_element(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) {
    return a.evidence < b.evidence;
  });
  chosen = best->chosen;
  result.extended = best->fit;
  result.unknown = best->unknown;

  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const JointFit less = search.fitted(result.extended, without(result.extended.effects, i));
    const auto others = without(chosen, i);
    const double all = Search::evidence(result.extended, chosen);
    Finding finding{
        chosen[i].candidate.hypothesis,
        result.extended.effects[i],
        all - Search::evidence(less, others),
        {}};
    for (auto& rival : search.refitted(less, others, search.scored(less, others), 15.0, 6)) {
      if (rival.chosen.candidate.hypothesis == finding.hypothesis) continue;
      const double odds = all - rival.evidence;
      if (odds < settings.tie_log_odds) {
        finding.tied_with.push_back(
            {rival.chosen.candidate.hypothesis, rival.fit.effects.back(), odds});
      }
    }
    result.findings.push_back(std::move(finding));
  }
  list_gross(readings, result.extended, result);
  return result;
}

}  // namespace sixdial::diagnosis
