#include "diagnosis/held_out.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/judging.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

bool speaks_against(
    const Readings& held_out, const JointFit& with, const JointFit& without, double log_odds) {
  JointFit here = applied(held_out, with);
  const JointFit less = applied(held_out, without);
  // Readings that are far off either way say nothing of either.
  Eigen::VectorXd counted(here.residual_mm.size());
  for (Eigen::Index row = 0; row < counted.size(); ++row) {
    const double nearest_mm =
        std::min(std::abs(here.residual_mm[row]), std::abs(less.residual_mm[row]));
    const double far_mm = kGrossSigma * here.s_mm * here.noise[row];
    counted[row] =
        std::isfinite(here.residual_mm[row] - less.residual_mm[row]) && nearest_mm < far_mm
            ? 1.0
            : 0.0;
  }
  const auto of_counted = [&](const Eigen::VectorXd& mm) -> Eigen::VectorXd {
    return (counted.array() > 0).select(mm, 0.0);
  };
  here.weight = counted;
  const Whitening whitening = here.whitening();
  const Eigen::VectorXd does = whitening(of_counted(less.residual_mm - here.residual_mm));
  const Eigen::VectorXd left = whitening(of_counted(here.residual_mm));
  // What is left here may be more than the noise of the fit.
  const double readings = std::max(1.0, counted.sum());
  const double variance = std::max(here.s_mm * here.s_mm, left.squaredNorm() / readings);
  const double signal = does.squaredNorm() / variance;
  // A cause that is there has log odds of about half its squared signal, give or take the
  // signal itself, and more where its size is known by few readings.
  constexpr double kTooLow = 2.5;
  const double fitted = std::max(1.0, with.weight.sum());
  const double spread = std::sqrt(signal * (1.0 + readings / fitted));
  const double here_odds = log_odds * here.s_mm * here.s_mm / variance;
  return here_odds < std::min(0.0, 0.5 * signal - kTooLow * spread);
}

}  // namespace sixdial::diagnosis
