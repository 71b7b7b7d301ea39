// One or two names that could stand for two others of an explanation together, though neither
// stands for one of them alone: dials C and D forward are E and F back, or a larger cuboid and
// A back, on a robot that stands elsewhere. Adding and exchanging names one by one never comes
// from such a pair to the other.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "diagnosis/search.h"

namespace sixdial::diagnosis {

/// Effects of a fit, by number.
using TwoEffects = std::array<std::size_t, 2>;

struct StandIn {
  std::vector<simulation::ActiveEffect> effects;  // with sizes, linear
  double evidence = 0.0;                          // linear
  [[nodiscard]] std::vector<Hypothesis> names() const;
};

class StandIns {
 public:
  /// What every effect without a searched value would do to the readings of this fit.
  StandIns(
      const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses);
  /// Sets without a name of the fit that explain about what these two do, best first.
  [[nodiscard]] std::vector<StandIn> of(const TwoEffects& two) const;

 private:
  const JointFit& fit_;
  std::vector<Hypothesis> names_;
  std::vector<Eigen::Index> first_;  // column of each name, and the end
  Eigen::MatrixXd columns_;          // whitened
  Eigen::MatrixXd normal_;           // C'C
};

/// The fit as if some of its effects were not in it, without fitting anew: what they do is left
/// over, and a reading counts as it does with them. A new fit may call all of it gross.
[[nodiscard]] JointFit without_effects(
    const JointFit& fit, const std::vector<std::size_t>& which);

/// What effect i of a fit costs in log evidence, for parameters that had to be found: in the
/// noise of this fit and beside its other effects. Not for an effect with a searched value.
[[nodiscard]] double cost_in(const JointFit& fit, std::size_t i);

}  // namespace sixdial::diagnosis
