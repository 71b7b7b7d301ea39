// Finds the causes of what a fit of the robot leaves over: several effects at once, each with
// the rivals that would explain the readings about as well, and "unknown" where a smooth
// function explains more than any effect of the catalogue.
// (Geodesists call these steps detection, identification and adaptation.)
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"
#include "diagnosis/search.h"
#include "diagnosis/unknown.h"

namespace sixdial::diagnosis {

struct NamingSettings {
  /// Over the whole catalogue: half of the 2 % that a verdict may say too much in, the other
  /// half is left for what has no name.
  double false_alarm_level = 0.01;
  double tie_log_odds = 2.0;      // rivals closer than this cannot be told apart
  double least_log_odds = 1.2;    // a further cause needs at least these
  double unknown_log_odds = 5.0;  // so does "unknown", a smooth function
  /// A smooth function is preferred to a named cause only if its log odds are higher by this: a
  /// drift, for example, is itself a smooth function of time.
  double name_preference = 5.0;
  /// Log odds that a cause needs while something smooth remains unexplained.
  double beside_unknown_log_odds = 8.0;
  /// The same for a step or a drift while the remainder wanders in time.
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
  /// A smooth function of these covariates would explain the readings as well; empty: none
  /// would.
  std::vector<std::string> tied_with_unknown{};
  double unknown_log_odds = 0.0;  // evidence for the name less evidence for that
  bool settled = true;            // the fit that it rests on has converged
  double left_out = 0.0;          // share of the readings that this fit does without
  /// Too large a share: they may say something else.
  [[nodiscard]] bool of_a_part() const;
  [[nodiscard]] bool certain() const {
    return settled && !of_a_part() && tied_with.empty() && !tied_with_nothing &&
           tied_with_unknown.empty();
  }
};

/// A smooth error that goes by the own value of what errs (own_curve.h).
struct OwnCurve {
  const simulation::Effect* effect = nullptr;  // a row of curves
  simulation::Place place{};
  std::vector<UnknownCandidate> parts{};       // with their kernels, one after the other
  UnknownCandidate smooth;                     // the first, with the columns of all
  double evidence = 0.0;                       // log evidence lost without it
  double half_span = 0.0, half_span_sd = 0.0;  // over the readings that were taken
  double rms = 0.0;                            // about its mean
  /// Length of its wave, in the unit of what it goes by; empty: its strongest part is none.
  std::optional<double> period{};
  Eigen::VectorXd in_readings_mm{};  // what it does to each
  std::vector<Rival> tied_with{};
  bool tied_with_nothing = false;
  std::vector<std::string> tied_with_unknown{};  // as Finding's
  double unknown_log_odds = 0.0;
  bool settled = true;
  double left_out = 0.0;
  // Filled by diagnose(), as Cause's: G1 alone shows it too, and so does G2 alone.
  bool on_g1 = false;
  double g2_log_odds = 0.0;
  bool confirmed = false;
  [[nodiscard]] bool of_a_part() const;
  [[nodiscard]] bool certain() const {
    return settled && !of_a_part() && tied_with.empty() && !tied_with_nothing &&
           tied_with_unknown.empty();
  }
};
/// Of one dial over its own reading, beyond what its maker allows [mm].
struct DialCurve : OwnCurve {
  std::size_t dial = 0;
  double limit_mm = 0.0;  // accuracy_mm of the dial
};
/// Of one joint over its own value [rad, or mm of a prismatic one].
struct JointCurve : OwnCurve {
  /// The best that the same joint's error does as a function of another joint's value: what
  /// flexibility alone gains. Log evidence, as that of the first part in `own_evidence`.
  double sham_evidence = 0.0;
  double own_evidence = 0.0;
};

struct GrossReading {
  int row = 0;
  double size_mm = 0.0;
  bool stale = false;
  bool near_edge = false;  // the tip touches the cuboid at or beyond the end of its face
};

struct NamedCauses {
  JointFit baseline;  // robot and clamp only
  JointFit extended;  // with the findings
  std::vector<Finding> findings;
  /// Smooth functions that no effect of the catalogue explains, and the rivals that do about as
  /// well.
  std::vector<UnknownCandidate> unknown;
  std::vector<UnknownCandidate> unknown_rivals;
  /// The rig file claims exactness that the readings contradict, by this log evidence. What it
  /// claims is then known to within what rig_known.h says in all that follows.
  std::optional<double> rig_geometry;
  /// What the dials' makers allow, as far as it shows: part of the fit, and no finding.
  std::vector<UnknownCandidate> background;
  /// Unequal masses behind joints that give under weight: part of `extended`, and no finding.
  std::vector<UnknownCandidate> masses;
  /// Part of the fit as well, and a finding each; not among `unknown`.
  std::vector<DialCurve> dial_curves;
  std::vector<JointCurve> joint_curves;
  /// The readings came back with the joint values set right by these curves: `extended` is a
  /// fit to them.
  bool joints_set_right = false;
  /// Both, those of the dials first: what becomes a part of the model (curves_in_model.h).
  [[nodiscard]] std::vector<OwnCurve> curves() const;
  /// Columns of what the dials do of their own: `background` and `dial_curves`.
  [[nodiscard]] Eigen::MatrixXd dial_columns(Eigen::Index readings) const;
  /// These, and those of the joints' curves.
  [[nodiscard]] Eigen::MatrixXd own_columns(Eigen::Index readings) const;
  /// Covariates of `unknown` and `unknown_rivals`, each once.
  [[nodiscard]] std::vector<std::string> depends_on() const;
  std::vector<GrossReading> gross;
  std::optional<Hypothesis> swap;
  double evidence = 0.0;  // log likelihood of the whole less what it costs
  double family_p_value = 1.0;
  std::vector<Candidate> candidates;  // scored against the baseline
  std::vector<NotTestable> not_testable;
};

/// Names the causes in a session. If two dials were found exchanged, `readings` comes back with
/// their readings set right; if many joints err by curves of their own, with the joint values.
[[nodiscard]] NamedCauses name_causes(Readings& readings, const NamingSettings& settings = {});

}  // namespace sixdial::diagnosis
