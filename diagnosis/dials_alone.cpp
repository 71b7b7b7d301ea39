#include "diagnosis/dials_alone.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

/// The first name that is not worth its place goes, or another takes it.
bool one_is_not_worth_it(
    const Search& search, const NamingSettings& settings, Explanation& found) {
  constexpr double kBetter = 0.1;
  for (std::size_t i = 0; i < found.chosen.size(); ++i) {
    Explanation less = search.without_for_dials(found, i);
    const bool dials = stands_in(found, less) != nullptr;
    // As likely as the dials, a name stays, and is tied with them.
    if (less.evidence > found.evidence - (dials ? 0.0 : settings.least_log_odds)) {
      found = std::move(less);
      return true;
    }
    if (!dials) continue;  // its rivals have been asked
    auto rivals = search.instead_of(found, i, less, kBetterRivals);
    if (!rivals.empty() && rivals.front().evidence > found.evidence + kBetter) {
      found = std::move(rivals.front());
      return true;
    }
  }
  return false;
}

}  // namespace

const UnknownCandidate* stands_in(const Explanation& found, const Explanation& less) {
  for (const UnknownCandidate& each : less.unknown) {
    const auto same = [&](const UnknownCandidate& other) {
      return other.kind == each.kind && other.enters == each.enters &&
             other.covariates == each.covariates;
    };
    if (each.is_background() && std::ranges::none_of(found.unknown, same)) return &each;
  }
  return nullptr;
}

void hold_against_dials(
    const Search& search, const NamingSettings& settings, Explanation& found) {
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    if (!one_is_not_worth_it(search, settings, found)) return;
  }
}

}  // namespace sixdial::diagnosis
