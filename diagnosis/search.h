// Which effect explains what the fit leaves? Every candidate's columns are projected off the
// fitted parameters' Jacobian and tried against the residual (score), the best are fitted
// jointly and compared by evidence. notes: nested evidence, n/2 ln SSE with a gross-error
// component.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// One hypothesis: an effect at a place.
struct Hypothesis {
  const simulation::Effect* effect = nullptr;
  simulation::Place place;
  /// "joint_backlash@joint2".
  [[nodiscard]] std::string name() const;
  friend bool operator==(const Hypothesis& a, const Hypothesis& b) {
    return a.effect == b.effect && a.place.name == b.place.name;
  }
};

/// What a hypothesis would do here, projected off everything already fitted.
struct Candidate {
  Hypothesis hypothesis;
  double searched = 0.0;   // best searched value, if the effect has one
  double gain = 0.0;       // rise of the log likelihood, linear
  double evidence = 0.0;   // gain less the cost of its parameters and its search
  double p_value = 1.0;    // of the gain under no effect, with its own search
  double surviving = 1.0;  // share of its columns that the fitted parameters do not absorb
  Eigen::MatrixXd normal;  // C'C of its projected, weighted columns, per unit of each parameter
};

/// Every testable hypothesis on this session, and those that are not, with the reason.
enum class WhyNotTestable {
  kNoDials,              // positions only
  kNoTemperature,        // no temperature was recorded
  kTemperatureConstant,  // it did not change
  kNoTime,               // no times were recorded
  kNoApproach,           // nobody knows from which side the joint came
  kOneApproach,          // the joint always came from the same side
  kAbsorbed,             // the fitted parameters take nearly all of it over: see its Limit
};
struct NotTestable {
  Hypothesis hypothesis;
  WhyNotTestable why = WhyNotTestable::kAbsorbed;
};
[[nodiscard]] std::vector<Hypothesis> hypotheses_for(
    const Readings& readings, std::vector<NotTestable>& not_testable);

/// Scores all hypotheses against a fit's residual; sorted by evidence, best first.
[[nodiscard]] std::vector<Candidate> score_all(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses);

/// Draws of noise through the same search: the share of them whose best candidate is at least
/// as good as a whole catalogue's `p_value`. Never 0: one more draw could be.
[[nodiscard]] double simulated_false_alarm(
    const Readings& readings, const JointFit& baseline,
    const std::vector<Hypothesis>& hypotheses, double p_value, int draws, std::uint64_t seed);

/// An effect without size, at a searched value if it has one.
[[nodiscard]] simulation::ActiveEffect at_rest(
    const Hypothesis& hypothesis, double searched = 0.0);

/// Least significance of the best of a whole catalogue: 1 - prod(1 - p_i).
[[nodiscard]] double family_p_value(const std::vector<Candidate>& candidates);

}  // namespace sixdial::diagnosis
