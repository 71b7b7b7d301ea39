// Two limits of every effect on this session: the smallest size at which it would have been
// detected, and the smallest at which it would have been named rightly, both with a probability
// of 80 % (geodesists: minimal detectable and minimal identifiable bias). Also which effects
// the fitted parameters absorb.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

struct Limit {
  Hypothesis hypothesis;
  std::string unit;                      // of its first parameter
  double detect = 0.0;                   // infinite: at no size
  double name = 0.0;                     // infinite: a rival does the same
  std::optional<Hypothesis> rival;       // the hardest to tell apart
  double surviving = 1.0;                // share that the fitted parameters do not absorb
  std::vector<std::string> absorbed_by;  // parameters that take it over, largest first
  double plausible = 0.0;
};

/// Of every testable hypothesis beside what is already explained by `fit`.
[[nodiscard]] std::vector<Limit> limits_of(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses,
    const NamingSettings& settings);

}  // namespace sixdial::diagnosis
