#include "diagnosis/identify.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <utility>

#include "diagnosis/baseline.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

/// What the search over a period or a sample costs, and its parameters.
double cost_of(const Candidate& candidate) { return candidate.gain - candidate.evidence; }
/// Of so many places and causes just this one: the prior that each further name must overcome.
double prior_cost(std::size_t hypotheses) {
  return std::log(static_cast<double>(std::max<std::size_t>(2, hypotheses)));
}

/// Log odds against what cannot be.
constexpr double kNever = 1e6;

/// Sizes far beyond what rigs of this kind show are less believable: a Cauchy density, so that
/// a large effect is not refused, up to a hundred times what is usual.
double implausibility(const ActiveEffect& active) {
  constexpr double kWidth = 5.0;
  double sum = 0.0;
  for (int i = 0; i < linear_count(*active.effect); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto parameter = parameter_at(*active.effect, active.place, i);
    if (parameter) sum += std::pow(active.x[k] / (kWidth * parameter->sigma), 2);
  }
  constexpr double kAbsurd = 20.0;
  return sum > kAbsurd * kAbsurd ? kNever : std::log1p(sum);
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

struct Chosen {
  Candidate candidate;
  double cost = 0.0;
};

/// An explanation: named effects, unnamed smooth functions, and the fit with both.
struct Explanation {
  std::vector<Chosen> chosen;
  std::vector<UnknownCandidate> unknown;
  JointFit fit;
  double evidence = 0.0;
};

class Search {
 public:
  Search(Readings& readings, const Settings& settings, std::vector<Hypothesis> hypotheses)
      : readings_(readings), settings_(settings), hypotheses_(std::move(hypotheses)) {}

  /// Candidates that are not in the explanation yet.
  [[nodiscard]] std::vector<Candidate> scored(const Explanation& with) const {
    std::vector<Hypothesis> open;
    for (const Hypothesis& each : hypotheses_) {
      const bool used = std::any_of(
          with.chosen.begin(), with.chosen.end(),
          [&](const Chosen& chosen) { return chosen.candidate.hypothesis == each; });
      if (!used) open.push_back(each);
    }
    return score_all(readings_, with.fit, open);
  }

  /// Fits what is chosen; effects start from their sizes in `sizes`. `afresh`: every reading
  /// counts at first, also those that were gross.
  [[nodiscard]] Explanation explained(
      const JointFit& from, std::vector<Chosen> chosen, std::vector<ActiveEffect> sizes,
      std::vector<UnknownCandidate> unknown, bool afresh = false) const {
    Explanation result{std::move(chosen), std::move(unknown), {}, 0.0};
    Eigen::MatrixXd random(readings_.count(), 0);
    if (!result.unknown.empty()) {
      random = readings_.nuisance();
      for (const UnknownCandidate& each : result.unknown) {
        const Eigen::Index before = random.cols();
        random.conservativeResize(Eigen::NoChange, before + each.columns.cols());
        random.rightCols(each.columns.cols()) = each.columns;
      }
    }
    result.fit =
        fit_jointly(readings_, from.model, std::move(sizes), afresh ? nullptr : &from, random);
    result.evidence = result.fit.log_likelihood;
    for (const Chosen& each : result.chosen) result.evidence -= each.cost;
    for (const ActiveEffect& each : result.fit.effects) {
      result.evidence -= out_of_range(readings_, each) ? kNever : implausibility(each);
    }
    for (const UnknownCandidate& each : result.unknown) {
      result.evidence -= each.cost + settings_.name_preference;
    }
    return result;
  }

  [[nodiscard]] Explanation without(const Explanation& all, std::size_t i) const {
    std::vector<Chosen> chosen = all.chosen;
    std::vector<ActiveEffect> sizes = all.fit.effects;
    chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(i));
    sizes.erase(sizes.begin() + static_cast<std::ptrdiff_t>(i));
    return explained(all.fit, std::move(chosen), std::move(sizes), all.unknown);
  }

  [[nodiscard]] Explanation without_unknown(const Explanation& all, std::size_t i) const {
    std::vector<UnknownCandidate> unknown = all.unknown;
    unknown.erase(unknown.begin() + static_cast<std::ptrdiff_t>(i));
    return explained(all.fit, all.chosen, all.fit.effects, std::move(unknown));
  }

  /// The best candidates refitted jointly with what is there, best first.
  [[nodiscard]] std::vector<Explanation> with_one_more(
      const Explanation& before, const std::vector<Candidate>& candidates, double within,
      std::size_t most, bool afresh = false) const {
    std::vector<Explanation> result;
    for (const Candidate& candidate : candidates) {
      if (result.size() >= most || candidate.evidence < candidates.front().evidence - within) {
        break;
      }
      std::vector<Chosen> chosen = before.chosen;
      chosen.push_back({candidate, cost_of(candidate) + prior_cost(hypotheses_.size())});
      std::vector<ActiveEffect> sizes = before.fit.effects;
      sizes.push_back(at_rest(candidate.hypothesis, candidate.searched));
      result.push_back(
          explained(before.fit, std::move(chosen), std::move(sizes), before.unknown, afresh));
    }
    std::stable_sort(
        result.begin(), result.end(),
        [](const Explanation& a, const Explanation& b) { return a.evidence > b.evidence; });
    return result;
  }

  /// What a few readings show that now count as gross: a step near the end looks like them.
  [[nodiscard]] std::vector<Candidate> scored_with_gross(const Explanation& with) const {
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

  /// The same names with what smooth functions add, if that is more than nothing.
  [[nodiscard]] Explanation with_unknown(const Explanation& names) const {
    constexpr std::size_t kMostUnknown = 2;
    Explanation best = names;
    while (best.unknown.size() < kMostUnknown) {
      auto candidates = score_unknown(readings_, best.fit);
      if (candidates.empty() || candidates.front().evidence <= settings_.unknown_log_odds) {
        break;
      }
      std::vector<UnknownCandidate> unknown = best.unknown;
      unknown.push_back(std::move(candidates.front()));
      Explanation next = explained(best.fit, best.chosen, best.fit.effects, std::move(unknown));
      if (next.evidence <= best.evidence) break;
      best = std::move(next);
    }
    return best;
  }

  /// With a new one in, an earlier choice may have a better rival, or no longer pay for itself.
  void reconsider(Explanation& now) const {
    for (std::size_t i = 0; now.chosen.size() > 1 && i < now.chosen.size(); ++i) {
      const Explanation less = without(now, i);
      auto rivals = with_one_more(less, scored(less), 15.0, 5);
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

 private:
  Readings& readings_;
  const Settings& settings_;
  std::vector<Hypothesis> hypotheses_;
};

/// A joint with backlash is half of it off where nobody knows which side it came from.
bool of_unknown_side(const JointFit& fit, const simulation::Circumstance& sample) {
  return std::any_of(fit.effects.begin(), fit.effects.end(), [&](const ActiveEffect& active) {
    return (active.effect->needs & simulation::kApproach) != 0 && active.place.joint >= 0 &&
           sample.approach[active.place.joint] == 0;
  });
}

bool touches_near_edge(
    const geometry::Rig& rig, std::size_t dial, const simulation::Scene& at) {
  const geometry::DialGeometry& geometry = rig.dials[dial].geometry;
  const auto contact = geometry::contact_on_face(
      geometry, {at.p_WE, at.gamma_rad}, at.side_mm,
      geometry::face_towards(geometry, at.gamma_rad));
  constexpr double kTips = 2.0;  // radii of the tip: the pose is not known to less
  return std::abs(contact.along_mm) > at.side_mm / 2 - kTips * geometry.tip_radius_mm;
}

void list_gross(const Readings& readings, const JointFit& fit, Identification& result) {
  constexpr double kGrossSigma = 5.0;
  const auto& rig = readings.model().rig();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  simulation::Scene scene;
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const double s_mm = fit.s_mm * fit.noise[row];
    if (std::abs(fit.residual_mm[row]) < kGrossSigma * s_mm || fit.weight[row] > 0.5) continue;
    const Row& each = readings.rows()[static_cast<std::size_t>(row)];
    const auto trial = static_cast<std::size_t>(each.trial);
    const simulation::Circumstance& sample = readings.circumstances()[trial];
    if (of_unknown_side(fit, sample)) continue;
    GrossReading gross{static_cast<int>(row), fit.residual_mm[row]};
    if (readings.has_dials()) {
      const auto dial = static_cast<std::size_t>(each.dial);
      gross.stale = std::abs(readings.measured_mm()[row] - sample.previous_mm[dial]) <
                    0.51 * rig.dials[dial].resolution_mm;
      gross.near_edge = extended.run(fit.model, readings.trials()[trial], sample, scene) &&
                        touches_near_edge(rig, dial, scene);
    }
    result.gross.push_back(gross);
  }
}

/// Exchanged dials: a parameter-free alternative, tried where much of the session is gross or
/// far off. The pair whose exchange explains the session best, if it does so beyond doubt.
std::optional<Hypothesis> find_swap(
    Readings& readings, const std::vector<Hypothesis>& hypotheses, JointFit& baseline) {
  // Per exchanged reading; what a 25 sigma error costs in the mixture, and more.
  constexpr double kBeyondDoubt = 50.0;
  if (!looks_wrong(readings, baseline)) return std::nullopt;
  std::optional<Hypothesis> found;
  std::optional<Readings> best_readings;
  JointFit best = baseline;
  double best_likelihood = baseline.log_likelihood + kBeyondDoubt;
  for (const Hypothesis& each : hypotheses) {
    if (!each.effect->exchanges_dials) continue;
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

/// Smooth functions whose evidence differs by less are not told apart: their evidence is that
/// of the linear score, not of a refit.
constexpr double kUnknownTie = 6.0;

/// Beside something smooth: names that it makes needless go, a name takes its place if it can,
/// names that it hid come; until nothing changes.
class Refinement {
 public:
  Refinement(const Search& search, const Settings& settings, Explanation& found)
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
    if (found_.unknown.empty()) return settings_.least_log_odds;
    for (const UnknownCandidate& each : found_.unknown) {
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
      names.unknown.clear();
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
      const Explanation less = search_.without_unknown(found_, i);
      auto named = search_.with_one_more(less, search_.scored(less), 25.0, 5);
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
    const double least =
        found_.unknown.empty() ? settings_.least_log_odds : settings_.beside_unknown_log_odds;
    auto choices = search_.with_one_more(found_, candidates, 15.0, 5);
    if (choices.empty() || choices.front().evidence <= found_.evidence + least) return false;
    found_ = std::move(choices.front());
    return true;
  }

  const Search& search_;
  const Settings& settings_;
  Explanation& found_;
};

}  // namespace

std::vector<std::string> Identification::depends_on() const {
  std::vector<std::string> result;
  for (const auto* list : {&unknown, &unknown_rivals}) {
    for (const UnknownCandidate& each : *list) {
      for (const std::string& covariate : each.covariates) {
        if (std::find(result.begin(), result.end(), covariate) == result.end()) {
          result.push_back(covariate);
        }
      }
    }
  }
  return result;
}

namespace {

/// Noise of each dial [mm] where one differs from the others, after all that was explained;
/// else empty.
std::vector<double> uneven_noise(const Readings& readings, const JointFit& fit) {
  constexpr double kLevel = 1e-4;
  constexpr double kWorthSaying = 1.3;
  constexpr double kFewest = 20.0;
  if (!readings.has_dials() || fit.weight.sum() <= fit.fitted + kFewest) return {};
  const std::size_t dials = readings.model().rig().dials.size();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dials));
  Eigen::VectorXd freedom = squares;
  Eigen::VectorXd before = Eigen::VectorXd::Ones(squares.size());
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const Eigen::Index dial = readings.rows()[static_cast<std::size_t>(row)].dial;
    squares[dial] += fit.weight[row] * std::pow(fit.residual_mm[row], 2);
    freedom[dial] += fit.weight[row];
    before[dial] = fit.noise[row];
  }
  freedom *= 1 - fit.fitted / fit.weight.sum();
  const Eigen::VectorXd relative = squares.cwiseQuotient(before.cwiseAbs2());
  bool uneven = false;
  std::vector<double> result(dials);
  for (Eigen::Index d = 0; d < squares.size(); ++d) {
    const double others = freedom.sum() - freedom[d];
    const bool enough = freedom[d] >= kFewest && others >= kFewest;
    double ratio = 1.0;
    if (enough) ratio = relative[d] / freedom[d] / ((relative.sum() - relative[d]) / others);
    const double large = std::max(ratio, 1 / ratio);
    if (enough && std::sqrt(large) > kWorthSaying) {
      const boost::math::fisher_f law(
          ratio > 1 ? freedom[d] : others, ratio > 1 ? others : freedom[d]);
      uneven = uneven || boost::math::cdf(boost::math::complement(law, large)) < kLevel;
    }
    result[static_cast<std::size_t>(d)] =
        enough ? std::sqrt(squares[d] / freedom[d]) : fit.s_mm * before[d];
  }
  return uneven ? result : std::vector<double>{};
}

Identification identify_with_noise(Readings& readings, const Settings& settings) {
  Identification result;
  result.baseline = fit_baseline(readings);
  readings.place_tool(result.baseline.model);
  const std::vector<Hypothesis> hypotheses = hypotheses_for(readings, result.not_testable);
  result.swap = find_swap(readings, hypotheses, result.baseline);
  readings.place_tool(result.baseline.model);
  Search search(readings, settings, hypotheses);

  // Names first; at each number of names, what smooth functions would add to them.
  Explanation names{{}, {}, result.baseline, result.baseline.log_likelihood};
  std::vector<Explanation> cuts;
  std::size_t best = 0;
  for (int round = 0;; ++round) {
    const auto candidates = search.scored(names);
    if (round == 0) {
      result.candidates = candidates;
      result.family_p_value = family_p_value(candidates);
    }
    cuts.push_back(search.with_unknown(names));
    if (cuts.back().evidence > cuts[best].evidence) best = cuts.size() - 1;
    // Two more names and still not better than fewer with something smooth.
    constexpr std::size_t kPatience = 2;
    if (round == settings.most_causes || cuts.size() - 1 - best >= kPatience) break;
    std::vector<Explanation> choices;
    if (family_p_value(candidates) <= settings.false_alarm_level) {
      choices = search.with_one_more(names, candidates, 25.0, 8);
    }
    double least = settings.least_log_odds;
    if (choices.empty() || choices.front().evidence <= names.evidence + least) {
      // A p value means nothing among gross errors: these must show more.
      choices = search.with_one_more(names, search.scored_with_gross(names), 25.0, 4, true);
      least = settings.unknown_log_odds;
    }
    if (choices.empty() || choices.front().evidence <= names.evidence + least) break;
    const std::size_t before = names.chosen.size();
    names = std::move(choices.front());
    search.reconsider(names);
    if (names.chosen.size() <= before) {
      cuts.push_back(search.with_unknown(names));
      if (cuts.back().evidence > cuts[best].evidence) best = cuts.size() - 1;
      break;
    }
  }
  Explanation found = std::move(cuts[best]);
  // A fit with something on top may have found the way to a better one without.
  for (std::size_t i = 0; found.unknown.empty() && i < found.chosen.size();) {
    Explanation less = search.without(found, i);
    if (less.evidence > found.evidence - settings.least_log_odds) {
      found = std::move(less);
      i = 0;
    } else {
      ++i;
    }
  }
  if (!found.unknown.empty()) Refinement(search, settings, found).run();
  result.extended = found.fit;
  result.unknown = found.unknown;
  for (std::size_t i = 0; i < found.unknown.size(); ++i) {
    const Explanation less = search.without_unknown(found, i);
    const auto same = [&](const UnknownCandidate& each) {
      return each.covariates == found.unknown[i].covariates &&
             each.enters == found.unknown[i].enters;
    };
    auto rivals = score_unknown(readings, less.fit);
    const auto own = std::find_if(rivals.begin(), rivals.end(), same);
    if (own == rivals.end()) continue;
    const double least = own->evidence - kUnknownTie;
    for (UnknownCandidate& rival : rivals) {
      if (!same(rival) && rival.evidence > least) {
        result.unknown_rivals.push_back(std::move(rival));
      }
    }
  }

  for (std::size_t i = 0; i < found.chosen.size(); ++i) {
    const Explanation less = search.without(found, i);
    Finding finding{
        found.chosen[i].candidate.hypothesis,
        found.fit.effects[i],
        found.evidence - less.evidence,
        {},
        found.evidence - less.evidence < settings.tie_log_odds};
    // Asked of a name that stands alone: beside others the smooth rival was asked at each cut.
    const Explanation unnamed =
        found.chosen.size() == 1 ? search.with_unknown(less) : Explanation{};
    if (unnamed.unknown.size() > found.unknown.size() &&
        found.evidence - unnamed.evidence < settings.tie_log_odds) {
      finding.tied_with_unknown = unnamed.unknown.back().covariates;
      finding.unknown_log_odds = found.evidence - unnamed.evidence;
    }
    // The others alone may have to be of absurd size.
    if (finding.evidence > kNever / 2) {
      finding.evidence = found.fit.log_likelihood - less.fit.log_likelihood;
    }
    for (auto& rival : search.with_one_more(less, search.scored(less), 15.0, 6)) {
      const Hypothesis& other = rival.chosen.back().candidate.hypothesis;
      if (other == finding.hypothesis) continue;
      const double odds = found.evidence - rival.evidence;
      if (odds < settings.tie_log_odds) {
        finding.tied_with.push_back({other, rival.fit.effects.back(), odds});
      }
    }
    result.findings.push_back(std::move(finding));
  }
  list_gross(readings, result.extended, result);
  return result;
}

}  // namespace

Identification identify(Readings& readings, const Settings& settings) {
  const Readings as_measured = readings;
  Identification result = identify_with_noise(readings, settings);
  // A dial that scatters more than the others would make causes of its own: with its own noise
  // all is asked again. Its tails come in step by step.
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
    result = identify_with_noise(readings, settings);
  }
  return result;
}

}  // namespace sixdial::diagnosis
