// The whole verdict on a session: what the simulation gets wrong, which causes, how sure, what
// the data could not have shown, and what naming gains on points that were not fitted.
//
//   all points -> causes -> robot and causes refitted on G1 alone -> judged on G2
//   G1 alone   -> causes again. A cause is confirmed if G1 alone finds it too, G2 is ten times
//                 likelier with it, nothing smooth would do as well and few readings were left
//                 out; else it is suspected
//
// Example:
//   const simulation::ForwardModel model(rig);
//   const std::vector<bool> judged = in_g2;  // by trial
//   const DiagnosisSettings settings{.null_draws = 0, .with_gain = false};  // quick
//   const Diagnosis found = diagnose(model, trials, judged, settings);
//   for (const Cause& cause : found.causes) show(cause.finding.hypothesis.name());
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "calibration/residual_model.h"
#include "diagnosis/estimates.h"
#include "diagnosis/gain.h"
#include "diagnosis/limits.h"
#include "diagnosis/model_choice.h"
#include "diagnosis/naming.h"
#include "diagnosis/rig_seen.h"
#include "diagnosis/scatter.h"

namespace sixdial::diagnosis {

struct DiagnosisSettings {
  NamingSettings search{};
  /// Draws of the simulated null behind the false alarm probability, and of the poses behind
  /// the intervals of the gain.
  int null_draws = 200;
  int gain_draws = 2000;
  std::uint64_t seed = 1;
  bool with_gain = true;  // the table; trains networks, most of the time of a small session
  bool with_limits = true;
  /// A session with more samples is judged by so many of them (drawn_samples.h), by at most 600
  /// with a free mount; 0: by all.
  std::size_t most_samples = 0;
};

struct Cause {
  Finding finding;
  std::vector<Estimate> estimate;
  double delta_bic = 0.0;      // twice the log evidence lost without it
  double visible_ratio = 0.0;  // RMS that nothing else can take over, over the noise
  bool on_g1 = false;          // G1 alone shows it too
  double g2_log_odds = 0.0;    // of G2's readings with it against without, both fitted on G1
  bool confirmed = false;
  double gain_mm = 0.0;  // mean position error on G2 without it less with it
};

/// What the fit leaves over and on which covariates it depends, before and after the causes.
struct Dependence {
  std::vector<std::string> covariates;  // as UnknownCandidate's
  std::string enters;
  double log_odds_before = 0.0, log_odds_after = 0.0;
  double rms_before_mm = 0.0, rms_after_mm = 0.0;
};

struct Remainder {
  bool significant = false;
  bool scatter = false;  // larger than the noise, without structure
  std::optional<ScatterFound> scatter_size;
  std::vector<std::string> depends_on;
  double rms_mm = 0.0;  // of the good readings after the causes
  std::vector<NoisyDial> noisy_dials;
};

struct ParameterChange {
  std::string name, unit;
  double nominal = 0.0;
  double baseline = 0.0, baseline_sd = 0.0;
  double extended = 0.0, extended_sd = 0.0;
};

struct Diagnosis {
  /// The readings as the diagnosis used them: exchanged dials set right, directions of travel
  /// by the extended fit. Empty where the diagnosis was cancelled before. The model given to
  /// diagnose() must outlive it.
  std::optional<Readings> readings;
  NamedCauses named;
  std::vector<Cause> causes;  // the exchanged dials first, then by evidence
  Noise noise;
  Remainder unexplained;
  std::vector<Dependence> dependence;
  std::vector<NotTestable> not_testable;
  std::vector<Limit> limits;
  std::vector<ParameterChange> parameters;
  std::vector<RigSeen> rig;    // by the fit with the causes; empty: the file claims exactness
  bool rig_confirmed = false;  // G1 alone contradicts the file's claim too
  std::vector<GainRow> gain;   // empty without points to judge on
  JointFit commanding;         // what the robot is commanded by (command_fit.h)
  std::vector<RigSeen> commanding_rig;  // by that fit, opened parts of a silent file too
  /// What a residual model learned of all that `commanding` leaves; empty without a table of
  /// the gain.
  std::optional<calibration::TrainedResidual> on_top;
  std::vector<CandidateErrors> choice;  // by G1 alone; empty without a table of the gain
  int g1_samples = 0, g2_samples = 0;   // that were drawn
  std::size_t drawn_of = 0;             // so many samples; 0: all were used
  bool held_out_by_program = false;     // the session has no G2: every third pose was
  /// Of the strongest finding: by sessions of pure noise, or by its p value without null_draws.
  double false_alarm_probability = 1.0;
  std::uint64_t seed = 1;
};

struct DiagnosisProgress {
  std::string stage;
  int done = 0, total = 0;
};

/// `trials` in time order; `held_out` says which are G2, same length. Throws
/// std::invalid_argument with too few readings to fit the robot. `stop` ends it between stages
/// and inside of long ones.
[[nodiscard]] Diagnosis diagnose(
    const simulation::ForwardModel& model, std::vector<simulation::Trial> trials,
    std::vector<bool> held_out, const DiagnosisSettings& settings = {},
    const std::function<void(const DiagnosisProgress&)>& progress = {},
    const std::stop_token& stop = {});

}  // namespace sixdial::diagnosis
