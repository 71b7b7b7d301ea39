// An explanation of a session: the robot, named effects, and smooth functions that nobody
// named, all fitted together; and the moves from one explanation to the next, by adding,
// leaving out or exchanging one part and fitting the whole anew.
#pragma once

#include <vector>

#include "diagnosis/known_fits.h"
#include "diagnosis/naming.h"
#include "diagnosis/stand_ins.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

/// Log odds against a rival that is impossible.
inline constexpr double kNever = 1e6;

/// A named effect, and its cost in log evidence: for its parameters, for the values that were
/// searched, and for having been picked out of a whole catalogue.
struct Chosen {
  Candidate candidate;
  double cost = 0.0;
};

struct Explanation {
  std::vector<Chosen> chosen;
  std::vector<UnknownCandidate> unknown;
  JointFit fit;
  /// Log likelihood less the costs of names and smooth functions, less what implausible sizes
  /// and a smooth function instead of a name cost.
  double evidence = 0.0;
  /// Smooth functions that are a finding: all but what the dials' makers allow.
  [[nodiscard]] std::size_t unknown_findings() const;
};

class Search {
 public:
  /// `readings` and `settings` must outlive it, and stay as they are.
  Search(
      const Readings& readings, const NamingSettings& settings,
      std::vector<Hypothesis> hypotheses)
      : readings_(readings), settings_(settings), hypotheses_(std::move(hypotheses)) {}

  /// Candidates that are not in the explanation yet, best first.
  [[nodiscard]] std::vector<Candidate> scored(const Explanation& with) const;
  /// The same, but gross readings count like all others: a step shortly before the end of a
  /// session looks like a few gross readings. Only candidates that explain much; none if there
  /// are hardly any gross readings.
  [[nodiscard]] std::vector<Candidate> scored_with_gross(const Explanation& with) const;

  [[nodiscard]] const Readings& readings() const { return readings_; }
  [[nodiscard]] const std::vector<Hypothesis>& hypotheses() const { return hypotheses_; }
  /// Some effects of an explanation, by number, at other places of the same kind instead.
  [[nodiscard]] Explanation at_places(
      const Explanation& all, const std::vector<std::size_t>& which,
      const std::vector<Hypothesis>& places) const;

  /// Without effect i; without smooth function i.
  [[nodiscard]] Explanation without(const Explanation& all, std::size_t i) const;
  [[nodiscard]] Explanation without_unknown(const Explanation& all, std::size_t i) const;
  /// The explanation with one more effect, for each candidate of the short list; best first.
  /// With `afresh`, every reading counts when the fit starts, also those that looked gross
  /// before.
  [[nodiscard]] std::vector<Explanation> with_one_more(
      const Explanation& before, const std::vector<Candidate>& candidates, Shortlist list,
      bool afresh = false) const;
  /// The same names with a new choice of the dials' background (error curves and habits within
  /// the makers' limits): in where it explains something, out where it does not any more.
  [[nodiscard]] Explanation with_background(Explanation now) const;
  [[nodiscard]] Explanation without_background(const Explanation& now) const;
  /// Without effect i, and with the dials' background chosen anew in its place.
  [[nodiscard]] Explanation without_for_dials(const Explanation& all, std::size_t i) const;
  /// The explanation with another name instead of effect i, or instead of smooth function i;
  /// best first. `less`: fitted without it.
  [[nodiscard]] std::vector<Explanation> instead_of(
      const Explanation& all, std::size_t i, const Explanation& less, Shortlist list) const;
  [[nodiscard]] std::vector<Explanation> instead_of_unknown(
      const Explanation& all, std::size_t i, const Explanation& less, Shortlist list) const;
  /// The same names with what smooth functions add, if that is more than nothing.
  [[nodiscard]] Explanation with_unknown(const Explanation& names) const;

  /// Explanations with other names for two of these. Both sides of `log_odds` count what their
  /// names cost in their own fits.
  struct Exchange {
    TwoEffects two;
    Explanation rival;
    double log_odds;  // evidence for the two less evidence for the rival
  };
  /// Where two names together have a better stand-in, it takes their place, until none has.
  /// Returns those that do about as well as what is then there.
  std::vector<Exchange> exchange_twos(Explanation& now) const;

  /// Looks at the earlier effects again after a new one was added: one of them may have a
  /// better rival now, or may not be worth its cost any more.
  void reconsider(Explanation& now) const;

 private:
  [[nodiscard]] Explanation with_stand_in(
      const Explanation& all, const TwoEffects& two, const StandIn& instead) const;
  /// What the last name costs, in the noise of the fit that has it. Before it was added, its
  /// signal may have looked like a scatter of arrivals, in which large columns cost little.
  void weigh_last_name(const Explanation& before, Explanation& with) const;
  [[nodiscard]] Explanation explained(
      const JointFit& from, std::vector<Chosen> chosen,
      std::vector<simulation::ActiveEffect> sizes, std::vector<UnknownCandidate> unknown,
      bool afresh = false) const;

  const Readings& readings_;
  const NamingSettings& settings_;
  std::vector<Hypothesis> hypotheses_;
  mutable KnownFits known_;
};

}  // namespace sixdial::diagnosis
