#include "diagnosis/tied_sets.h"

#include <algorithm>
#include <map>

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
    const Search& search, const NamingSettings& settings, const Explanation& found,
    std::vector<Finding>& findings) {
  std::map<const simulation::Effect*, Group> groups;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const simulation::Effect* effect = findings[i].hypothesis.effect;
    if (!effect->searched) groups[effect].push_back(i);
  }
  for (const auto& [effect, group] : groups) {
    if (group.size() < 2) continue;
    std::vector<Hypothesis> places;
    for (const Hypothesis& each : search.hypotheses()) {
      if (each.effect == effect) places.push_back(each);
    }
    for (const auto& set : sets_of(places, group.size())) {
      const Explanation rival = search.at_places(found, group, set);
      const double log_odds = found.evidence - rival.evidence;
      if (log_odds < settings.tie_log_odds) tie(findings, group, rival, set, log_odds);
    }
  }
}

}  // namespace sixdial::diagnosis
