// The two limits of every effect on this session: the smallest size that it would have been
// detected at, and the smallest at which it would have been named rightly, alone and for
// certain (geodesists' MDB and MIB), both with 80 % power; and which effects the fitted
// parameters absorb.
//
// Power is counted, not approximated: noise and effect are drawn many times, an effect of
// several parameters in any direction, a searched one at several places of its search, and the
// linear evidence of the effect, of its hardest rivals and of nothing at all is compared as the
// search does. A name that is tied with anything, with nothing too, is no right name.
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
