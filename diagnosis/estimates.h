// The size of a fitted cause in numbers.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

struct Estimate {
  std::string name, unit;
  double value = 0.0;
  double sd = 0.0;  // NaN where the value was searched, not fitted
};
/// Of effect number `cause` of the fit. Parameters that its place does not have, or that move
/// no reading, are left out.
[[nodiscard]] std::vector<Estimate> estimates_of(const JointFit& fit, std::size_t cause);

/// RMS of what that effect does to the readings, less what the fit's parameters can take over,
/// in units of the noise. A searched parameter and smooth functions are not counted as able to.
[[nodiscard]] double visible_ratio(
    const Readings& readings, const JointFit& fit, std::size_t cause);

}  // namespace sixdial::diagnosis
