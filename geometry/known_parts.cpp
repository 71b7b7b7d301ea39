#include "geometry/known_parts.h"

#include <Eigen/QR>
#include <cmath>

namespace sixdial::geometry {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

std::vector<KnownPart> known_parts(const InstrumentModel& instrument) {
  std::vector<KnownPart> known;
  for (Index k = 0; k < instrument.parameter_count(); ++k) {
    if (!std::isfinite(instrument.known_to[k])) continue;
    known.push_back(
        {.first = static_cast<int>(k),
         .value = instrument.nominal[k],
         .sd = instrument.known_to[k]});
  }
  for (const KnownDistance& each : instrument.distances) {
    known.push_back(
        {.first = each.first, .second = each.second, .value = each.mm, .sd = each.sd_mm});
  }
  return known;
}

double value_of(const KnownPart& known, const Values& x, RowVectorXd* by_x) {
  if (by_x != nullptr) by_x->setZero(x.size());
  if (known.second < 0) {
    if (by_x != nullptr) (*by_x)[known.first] = 1.0;
    return x[known.first];
  }
  const Eigen::Vector3d apart = x.segment<3>(known.second) - x.segment<3>(known.first);
  const double length = apart.norm();
  if (by_x != nullptr && length > 0.0) {
    by_x->segment<3>(known.second) = apart.transpose() / length;
    by_x->segment<3>(known.first) = -apart.transpose() / length;
  }
  return length;
}

MatrixXd slopes_of(const std::vector<KnownPart>& known, const Values& x) {
  MatrixXd slopes(std::ssize(known), x.size());
  RowVectorXd by_x;
  for (std::size_t k = 0; k < known.size(); ++k) {
    static_cast<void>(value_of(known[k], x, &by_x));
    slopes.row(static_cast<Index>(k)) = by_x;
  }
  return slopes;
}

VectorXd at_known_values(const std::vector<KnownPart>& known, VectorXd x) {
  constexpr int kSteps = 20;
  constexpr double kThere = 1e-12;
  for (int step = 0; step < kSteps && !known.empty(); ++step) {
    VectorXd missing(std::ssize(known));
    for (std::size_t k = 0; k < known.size(); ++k) {
      missing[static_cast<Index>(k)] = known[k].value - value_of(known[k], x);
    }
    if (missing.cwiseAbs().maxCoeff() < kThere) break;
    x += slopes_of(known, x).completeOrthogonalDecomposition().solve(missing);
  }
  return x;
}

}  // namespace sixdial::geometry
