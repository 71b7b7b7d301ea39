#include "diagnosis/significance.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace sixdial::diagnosis {

double p_value_of_gain(double gain, int parameters) {
  if (!(gain > 0) || parameters < 1) return 1.0;  // not a number is no gain
  const boost::math::chi_squared twice_the_gain(parameters);
  return boost::math::cdf(boost::math::complement(twice_the_gain, 2 * gain));
}

double p_value_of_best(double smallest, double tries) {
  return -std::expm1(tries * std::log1p(-std::min(smallest, 1 - 1e-12)));
}

double independent_tries(const simulation::Effect& effect, std::size_t values) {
  constexpr double kSteps = 12.0;
  constexpr double kShare = 0.7;  // of neighbouring periods
  if (values <= 1) return 1.0;
  return effect.is_step ? kSteps : kShare * static_cast<double>(values);
}

}  // namespace sixdial::diagnosis
