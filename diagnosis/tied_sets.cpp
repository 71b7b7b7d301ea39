#include "diagnosis/tied_sets.h"

#include <algorithm>
#include <map>
#include <utility>

namespace sixdial::diagnosis {
namespace {

/// Findings by number, of one effect.
using Group = std::vector<std::size_t>;

/// All choices of `count` out of `all`, at most kMostSets of them.
std::vector<std::vector<Hypothesis>> sets_of(
    const std::vector<Hypothesis>& all, std::size_t count) {
  constexpr std::size_t kMostSets = 40;
  std::vector<bool> taken(all.size(), false);
  std::fill_n(taken.begin(), static_cast<std::ptrdiff_t>(std::min(count, all.size())), true);
  std::vector<std::vector<Hypothesis>> result;
  do {
    std::vector<Hypothesis> set;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (taken[i]) set.push_back(all[i]);
    }
    result.push_back(std::move(set));
  } while (result.size() < kMostSets && std::prev_permutation(taken.begin(), taken.end()));
  return result;
}

/// What the places of one effect do to the readings, whitened and off all that is fitted
/// besides: whether a set of them could stand for those that were found.
class Spans {
 public:
  Spans(
      const Readings& readings, const JointFit& fit, const Group& group,
      const std::vector<Hypothesis>& places)
      : places_(places), s_mm_(fit.s_mm) {
    JointFit others = fit;
    others.J.resize(fit.J.rows(), 0);
    Eigen::Index column = fit.model.size();
    const auto keep = [&](Eigen::Index first, Eigen::Index count) {
      const Eigen::Index before = others.J.cols();
      others.J.conservativeResize(Eigen::NoChange, before + count);
      others.J.rightCols(count) = fit.J.middleCols(first, count);
    };
    keep(0, column);
    for (std::size_t k = 0; k < fit.effects.size(); ++k) {
      const int own = fitted_count(*fit.effects[k].effect);
      if (std::ranges::find(group, k) == group.end()) keep(column, own);
      column += own;
    }
    const Projector projector(others);
    const simulation::ExtendedModel extended(readings.model(), fit.effects);
    const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
    found_ = Eigen::VectorXd::Zero(readings.count());
    for (const Hypothesis& place : places) {
      Eigen::MatrixXd does = projector.whitening()(
          effect_columns(readings, fit.model, extended, at_rest(place), simulated));
      does -= projector.Q() * (projector.Q().transpose() * does);
      for (const std::size_t i : group) {
        if (fit.effects[i].place.name != place.place.name) continue;
        for (Eigen::Index k = 0; k < does.cols(); ++k) {
          found_ += fit.effects[i].x[static_cast<std::size_t>(k)] * does.col(k);
        }
      }
      does_.push_back(std::move(does));
    }
  }

  /// Log likelihood that the readings lose, about, if this set stands for what was found.
  [[nodiscard]] double loss_of(const std::vector<Hypothesis>& set) const {
    Eigen::MatrixXd columns(found_.size(), 0);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (std::ranges::find(set, places_[i]) == set.end()) continue;
      const Eigen::Index before = columns.cols();
      columns.conservativeResize(Eigen::NoChange, before + does_[i].cols());
      columns.rightCols(does_[i].cols()) = does_[i];
    }
    const Eigen::MatrixXd Q = orthonormal_basis(columns);
    const Eigen::VectorXd left = found_ - Q * (Q.transpose() * found_);
    return 0.5 * left.squaredNorm() / (s_mm_ * s_mm_);
  }

 private:
  const std::vector<Hypothesis>& places_;
  double s_mm_;
  std::vector<Eigen::MatrixXd> does_;  // by place
  Eigen::VectorXd found_;              // of the group
};

bool holds(const std::vector<Hypothesis>& set, const Hypothesis& each) {
  return std::ranges::find(set, each) != set.end();
}

void tie(
    std::vector<Finding>& findings, const Group& group, const Explanation& rival,
    const std::vector<Hypothesis>& set, double log_odds) {
  std::vector<Hypothesis> own;
  for (const std::size_t i : group) own.push_back(findings[i].hypothesis);
  for (const std::size_t i : group) {
    Finding& finding = findings[i];
    if (holds(set, finding.hypothesis)) continue;
    for (const Hypothesis& other : set) {
      const bool known = std::ranges::any_of(
          finding.tied_with, [&](const Rival& each) { return each.hypothesis == other; });
      if (known || holds(own, other)) continue;
      const auto fitted =
          std::ranges::find_if(rival.fit.effects, [&](const simulation::ActiveEffect& active) {
            return active.effect == other.effect && active.place.name == other.place.name;
          });
      if (fitted != rival.fit.effects.end()) {
        finding.tied_with.push_back({other, *fitted, log_odds});
      }
    }
  }
}

}  // namespace

void tie_alike_sets(
    const Readings& readings, const Search& search, const NamingSettings& settings,
    const Explanation& found, const std::vector<Search::Exchange>& exchanges,
    std::vector<Finding>& findings) {
  for (const Search::Exchange& each : exchanges) {
    std::vector<Hypothesis> instead;
    for (std::size_t i = found.chosen.size() - 2; i < each.rival.chosen.size(); ++i) {
      instead.push_back(each.rival.chosen[i].candidate.hypothesis);
    }
    tie(findings, {each.two[0], each.two[1]}, each.rival, instead, each.log_odds);
  }
  std::map<const simulation::Effect*, Group> groups;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const simulation::Effect* effect = findings[i].hypothesis.effect;
    if (!effect->searched) groups[effect].push_back(i);
  }
  for (const auto& [effect, group] : groups) {
    if (group.size() < 3) continue;  // two: among the exchanges
    std::vector<Hypothesis> places;
    for (const Hypothesis& each : search.hypotheses()) {
      if (each.effect == effect) places.push_back(each);
    }
    const Spans spans(readings, found.fit, group, places);
    for (const auto& set : sets_of(places, group.size())) {
      if (spans.loss_of(set) > kTies.within) continue;  // as any rival that is too far off
      const Explanation rival = search.at_places(found, group, set);
      const double log_odds = found.evidence - rival.evidence;
      if (log_odds < settings.tie_log_odds) tie(findings, group, rival, set, log_odds);
    }
  }
}

}  // namespace sixdial::diagnosis
