#include "diagnosis/growing.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/crew.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

const UnknownCandidate* rig_of(const Explanation& found) {
  const auto rig =
      std::ranges::find(found.unknown, UnknownKind::kRigGeometry, &UnknownCandidate::kind);
  return rig == found.unknown.end() ? nullptr : &*rig;
}

namespace {

/// The names with one more, if that is worth it.
std::optional<Explanation> with_next_name(
    const Search& search, const NamingSettings& settings, const Explanation& names,
    const std::vector<Candidate>& candidates) {
  std::vector<Explanation> choices;
  if (family_p_value(candidates) <= settings.false_alarm_level) {
    choices = search.with_one_more(names, candidates, kNextNames);
  }
  double least = settings.least_log_odds;
  if (choices.empty() || choices.front().evidence <= names.evidence + least) {
    // A p value means nothing among gross errors: these must show more.
    choices = search.with_one_more(
        names, search.scored_with_gross(names), kNextNamesAmongGross, true);
    least = settings.unknown_log_odds;
  }
  if (choices.empty() || choices.front().evidence <= names.evidence + least) {
    return std::nullopt;
  }
  return std::move(choices.front());
}

/// The same where the dials' own curves and habits are in the explanation: these may stand for
/// the very thing that has a name, so that it is looked for without them too. A name that does
/// as well as they do is taken, and tied with them (finding_of).
std::optional<Explanation> with_next_name_anyhow(
    const Search& search, const NamingSettings& settings, const Explanation& names,
    const std::vector<Candidate>& candidates) {
  std::optional<Explanation> beside, instead;
  const bool background = names.unknown.size() != names.unknown_findings();
  calibration::in_parallel(background ? 2 : 1, [&](int part) {
    if (part == 0) {
      beside = with_next_name(search, settings, names, candidates);
      return;
    }
    const Explanation bare = search.without_background(names);
    instead = with_next_name(search, settings, bare, search.scored(bare));
    if (instead) *instead = search.with_background(std::move(*instead));
  });
  if (!instead) return beside;
  const double least = beside ? beside->evidence : names.evidence;
  return instead->evidence > least ? std::move(instead) : std::move(beside);
}

/// Whether a few more names explain more than the rig itself does, all of which may be off: a
/// dial or two that stand elsewhere have names.
bool names_beat(
    const Explanation& rig, const Search& search, const NamingSettings& settings,
    Explanation names, std::vector<Candidate> candidates) {
  constexpr int kFew = 3;
  for (int more = 1; more <= kFew; ++more) {
    auto next = with_next_name_anyhow(search, settings, names, candidates);
    if (!next) return false;
    names = std::move(*next);
    search.reconsider(names);
    search.exchange_twos(names);
    if (names.evidence > rig.evidence) return true;
    if (more == kFew) return false;
    candidates = search.scored(names);
  }
  return false;
}

}  // namespace

Explanation best_of_growing(
    const Search& search, const NamingSettings& settings, NamedCauses& result) {
  Explanation names =
      search.with_background({{}, {}, result.baseline, result.baseline.log_likelihood});
  std::vector<Explanation> cuts;  // by number of names
  std::size_t best = 0;
  const auto cut_here = [&](Explanation with) {
    cuts.push_back(std::move(with));
    if (cuts.back().evidence > cuts[best].evidence) best = cuts.size() - 1;
  };
  for (int round = 0;; ++round) {
    const auto candidates = search.scored(names);
    if (round == 0) {
      result.candidates = candidates;
      result.family_p_value = family_p_value(candidates);
    }
    // Nearly every round asks for both: something smooth, and the next name.
    Explanation smooth;
    std::optional<Explanation> next;
    // More threads than two are better shared by the parts of each.
    const bool ahead = calibration::crew_size() == 2 && round < settings.most_causes;
    calibration::in_parallel(ahead ? 2 : 1, [&](int part) {
      if (part == 0) {
        smooth = search.with_unknown(names);
      } else {
        next = with_next_name_anyhow(search, settings, names, candidates);
      }
    });
    cut_here(std::move(smooth));
    // Two more names and still not better than fewer with something smooth.
    constexpr std::size_t kPatience = 2;
    if (round == settings.most_causes || cuts.size() - 1 - best >= kPatience) break;
    if (rig_of(cuts.back()) != nullptr && best + 1 == cuts.size() &&
        !names_beat(cuts.back(), search, settings, names, candidates)) {
      break;  // the rig is to be opened first
    }
    if (!ahead) next = with_next_name_anyhow(search, settings, names, candidates);
    if (!next) break;
    const std::size_t before = names.chosen.size();
    names = std::move(*next);
    search.reconsider(names);
    search.exchange_twos(names);
    names = search.with_background(std::move(names));
    if (names.chosen.size() <= before) {
      cut_here(search.with_unknown(names));
      break;
    }
  }
  return std::move(cuts[best]);
}

}  // namespace sixdial::diagnosis
