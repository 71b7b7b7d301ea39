// How large an effect is, as people read it: its row's `size` with the figures filled in.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "simulation/effect.h"

namespace sixdial::simulation {

/// "0.0340° ± 0.0020°": value and expanded uncertainty, k = 2, with two digits of the latter;
/// angles in degrees, shares in %. Standard deviation not finite: three digits of the value.
[[nodiscard]] std::string quantity_in_words(double value, double sd, std::string_view unit);

/// So many significant digits without an exponent: 44523 in three is "44500", 0.0000316 stays.
[[nodiscard]] std::string in_digits(double value, int digits);

/// One parameter of an effect as it was found.
struct FoundParameter {
  std::string_view name;
  double value = 0.0;
  double sd = 0.0;  // NaN where it was searched, not fitted
  std::string_view unit;
};
/// "amplitude 0.041° ± 0.002° (k = 2)", "0.0121 mm ± 0.0008 mm from sample 71 on (k = 2)". A
/// row without `size` gives each parameter with its name; a single parameter is given without.
/// What stands in [ ] in `size` is left out where a figure in it was not found.
[[nodiscard]] std::string size_in_words(
    const Effect& effect, std::span<const FoundParameter> found);

}  // namespace sixdial::simulation
