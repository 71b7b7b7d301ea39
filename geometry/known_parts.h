// What is known of an instrument before any sample: its parameters to within a deviation, and
// distances of places among them. One list for all that fits: each thing known is a function of
// the parameters x with a value and a standard deviation.
//
//   h(x) = x_i   or   |x_j.. - x_i..|,   h(x) = value +- sd
#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

struct KnownPart {
  int first = -1;   // index of a parameter, or of the first of a place's three
  int second = -1;  // -1: h is the parameter `first`
  double value = 0.0;
  double sd = 0.0;
};

/// The instrument's parameters that are known, then the distances.
[[nodiscard]] std::vector<KnownPart> known_parts(const InstrumentModel& instrument);

/// h(x) and, unless null, dh/dx (as many entries as x); zero where two places are at the same
/// point.
[[nodiscard]] double value_of(
    const KnownPart& known, const Values& x, Eigen::RowVectorXd* by_x = nullptr);

/// dh/dx of all of them, parts x parameters.
[[nodiscard]] Eigen::MatrixXd slopes_of(const std::vector<KnownPart>& known, const Values& x);

/// The parameters nearest to x at which all of them have their values.
[[nodiscard]] Eigen::VectorXd at_known_values(
    const std::vector<KnownPart>& known, Eigen::VectorXd x);

}  // namespace sixdial::geometry
