// From readings to a verdict: detect, identify, adapt (notes: DIA), with several effects at
// once, ties as sets, and "unknown" where a smooth function explains more than any name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/search.h"
#include "diagnosis/unknown.h"

namespace sixdial::diagnosis {

struct Settings {
  double false_alarm_level = 0.02;  // over the whole catalogue
  double tie_log_odds = 2.0;        // rivals closer than this cannot be told apart
  double least_log_odds = 1.2;      // what any further name must show
  double unknown_log_odds = 5.0;    // what a smooth remainder must show
  /// What a smooth function must explain better by, to be preferred to a name: a drift is also
  /// a smooth function of time.
  double name_preference = 5.0;
  /// What a name must show beside something smooth that remains.
  double beside_unknown_log_odds = 8.0;
  /// The same for a step or a drift beside something that wanders in time.
  double beside_wandering_log_odds = 30.0;
  int most_causes = 6;
};

struct Rival {
  Hypothesis hypothesis;
  simulation::ActiveEffect fitted;
  double log_odds = 0.0;  // evidence for the named one less evidence for this one
};

struct Finding {
  Hypothesis hypothesis;
  simulation::ActiveEffect fitted;
  double evidence = 0.0;  // log evidence lost if this one is left out
  std::vector<Rival> tied_with;
  bool tied_with_nothing = false;  // too weak to be sure that there is anything
  /// Something smooth in these would do as well; empty: it would not.
  std::vector<std::string> tied_with_unknown{};
  double unknown_log_odds = 0.0;  // evidence for the name less evidence for that
  bool settled = true;            // the fit that it rests on has converged
  [[nodiscard]] bool certain() const {
    return settled && tied_with.empty() && !tied_with_nothing && tied_with_unknown.empty();
  }
};

struct GrossReading {
  int row = 0;
  double size_mm = 0.0;
  bool stale = false;
  bool near_edge = false;  // the tip touches the cuboid at or beyond the end of its face
};

struct Identification {
  JointFit baseline;  // robot and clamp only
  JointFit extended;  // with the findings
  std::vector<Finding> findings;
  /// Smooth functions that nobody named, and for each its rivals that do about as well.
  std::vector<UnknownCandidate> unknown;
  std::vector<UnknownCandidate> unknown_rivals;
  /// Covariates of both, each once.
  [[nodiscard]] std::vector<std::string> depends_on() const;
  std::vector<GrossReading> gross;
  std::optional<Hypothesis> swap;
  double evidence = 0.0;  // log likelihood of the whole less what it costs
  double family_p_value = 1.0;
  std::vector<Candidate> candidates;  // scored against the baseline
  std::vector<NotTestable> not_testable;
};

/// `readings` come out as they were explained: with exchanged dials set right.
[[nodiscard]] Identification identify(Readings& readings, const Settings& settings = {});

}  // namespace sixdial::diagnosis
