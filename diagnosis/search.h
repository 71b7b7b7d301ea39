// Which effect explains what a fit leaves over? The readings that each effect would cause are
// first freed of what the fitted parameters can imitate, then compared with the residual: its
// score. The best are fitted together with the robot and compared by their evidence.
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

/// What an effect would explain of the residual, beyond what the fitted parameters can imitate.
struct Candidate {
  Hypothesis hypothesis;
  double searched = 0.0;   // best searched value, if the effect has one
  double gain = 0.0;       // rise of the log likelihood, linear
  double evidence = 0.0;   // gain less the cost of its parameters and its search
  double p_value = 1.0;    // of the gain under no effect, with its own search
  double surviving = 1.0;  // share of its columns that the fitted parameters do not absorb
  Eigen::VectorXd sizes;   // linear, of the parameters that do something
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

/// The same search on sessions of pure noise: the share of draws whose best candidate is at
/// least as significant as `p_value`. Never 0, because one more draw might be.
[[nodiscard]] double simulated_false_alarm(
    const Readings& readings, const JointFit& baseline,
    const std::vector<Hypothesis>& hypotheses, double p_value, int draws, std::uint64_t seed);

/// The effect with size 0, at a searched value if it has one.
[[nodiscard]] simulation::ActiveEffect at_rest(
    const Hypothesis& hypothesis, double searched = 0.0);

/// Significance of the best of a whole catalogue of tries: 1 - prod(1 - p_i).
[[nodiscard]] double family_p_value(const std::vector<Candidate>& candidates);

}  // namespace sixdial::diagnosis
