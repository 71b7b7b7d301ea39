// What the search for the size of an effect, and over its searched values, is made of
// (limits.cpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

/// Some of the searched values, evenly. A step just where it imitates a slow change best is its
/// hardest rival: of these there are more.
inline std::vector<double> few_of(std::vector<double> values, bool is_step) {
  const std::size_t few = is_step ? 24 : 6;
  if (values.size() <= few) return values;
  std::vector<double> result;
  for (std::size_t i = 0; i < few; ++i) {
    result.push_back(values[(2 * i + 1) * values.size() / (2 * few)]);
  }
  return result;
}

/// Of an effect so many times its plausible size.
inline double implausibility(double times) {
  return std::log1p(std::pow(times / kBelievedWidth, 2));
}

/// The search is averaged over: where many values do as well as the best, it costs little. Each
/// value that is not here does as well as one that is, but none as well as the best.
inline double cost_of_search(
    const std::vector<double>& evidences, std::size_t best, double searched) {
  const double each =
      evidences.size() > 1 ? (searched - 1) / static_cast<double>(evidences.size() - 1) : 0.0;
  double sum = 1.0;
  for (std::size_t i = 0; i < evidences.size(); ++i) {
    if (i != best) sum += each * std::exp(evidences[i] - evidences[best]);
  }
  return std::log(searched / sum);
}

/// Smallest size in [low, high] at which `enough` holds, by bisection of its logarithm.
template <typename Test>
double least_size(double low, double high, Test&& enough) {
  if (!enough(high)) return std::numeric_limits<double>::infinity();
  constexpr int kHalvings = 12;  // of eight decades: to half a per cent
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(low * high);
    (enough(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace sixdial::diagnosis
