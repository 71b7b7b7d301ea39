// How often chance alone does as well as an effect, or as the best of many that were tried.
#pragma once

#include <cstddef>

#include "simulation/effect.h"

namespace sixdial::diagnosis {

/// Of a rise of the log likelihood by `gain` with so many more parameters: twice the gain is
/// chi-squared if there is nothing.
[[nodiscard]] double p_value_of_gain(double gain, int parameters);

/// The best of so many tries that know nothing of each other: 1 - (1 - smallest)^tries.
[[nodiscard]] double p_value_of_best(double smallest, double tries);

/// How many such tries a search over `values` amounts to: neighbours find nearly the same.
[[nodiscard]] double independent_tries(const simulation::Effect& effect, std::size_t values);

}  // namespace sixdial::diagnosis
