// An explanation of a session: the robot, named effects, and smooth functions that nobody
// named, all fitted together; and the moves from one explanation to the next, by adding,
// leaving out or exchanging one part and fitting the whole anew.
#pragma once

#include <vector>

#include "diagnosis/identify.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

/// Log odds against what cannot be.
inline constexpr double kNever = 1e6;

/// A named effect, and what its parameters, its search and its being one of so many cost it in
/// log evidence.
struct Chosen {
  Candidate candidate;
  double cost = 0.0;
};

struct Explanation {
  std::vector<Chosen> chosen;
  std::vector<UnknownCandidate> unknown;
  JointFit fit;
  double evidence = 0.0;  // log likelihood less all costs
};

class Search {
 public:
  /// `readings` and `settings` must outlive it.
  Search(const Readings& readings, const Settings& settings, std::vector<Hypothesis> hypotheses)
      : readings_(readings), settings_(settings), hypotheses_(std::move(hypotheses)) {}

  /// Candidates that are not in the explanation yet, best first.
  [[nodiscard]] std::vector<Candidate> scored(const Explanation& with) const;
  /// The same with gross readings counted like all others: a step shortly before the end looks
  /// like a few gross readings. Empty if there are next to none.
  [[nodiscard]] std::vector<Candidate> scored_with_gross(const Explanation& with) const;

  /// Without effect i; without smooth function i.
  [[nodiscard]] Explanation without(const Explanation& all, std::size_t i) const;
  [[nodiscard]] Explanation without_unknown(const Explanation& all, std::size_t i) const;
  /// One for each candidate of the short list: what there is and this one, best first.
  /// `afresh`: every reading counts at first, also those that were gross.
  [[nodiscard]] std::vector<Explanation> with_one_more(
      const Explanation& before, const std::vector<Candidate>& candidates, Shortlist list,
      bool afresh = false) const;
  /// The same names with what smooth functions add, if that is more than nothing.
  [[nodiscard]] Explanation with_unknown(const Explanation& names) const;

  /// After a new name has come in: an earlier one may have a better rival now, or may no longer
  /// be worth its cost.
  void reconsider(Explanation& now) const;

 private:
  [[nodiscard]] Explanation explained(
      const JointFit& from, std::vector<Chosen> chosen,
      std::vector<simulation::ActiveEffect> sizes, std::vector<UnknownCandidate> unknown,
      bool afresh = false) const;

  const Readings& readings_;
  const Settings& settings_;
  std::vector<Hypothesis> hypotheses_;
};

}  // namespace sixdial::diagnosis
