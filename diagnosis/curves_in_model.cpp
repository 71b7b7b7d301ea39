#include "diagnosis/curves_in_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/stages.h"
#include "simulation/smooth_function.h"

namespace sixdial::diagnosis {
namespace {

bool is_of_a_dial(const OwnCurve& curve) { return curve.place.dial >= 0; }

/// What errs in each reading per unit of the curve, and the number that the curve goes by.
struct Along {
  Eigen::VectorXd per_unit, at;
};

Along along(const Readings& readings, const JointFit& fit, const OwnCurve& curve) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  if (is_of_a_dial(curve)) {
    Along result{Eigen::VectorXd::Zero(readings.count()), simulated};
    for (const Eigen::Index row :
         readings.rows_of_dial(static_cast<std::size_t>(curve.place.dial))) {
      result.per_unit[row] = 1.0;
    }
    return result;
  }
  Along result{
      stage_columns(
          readings, fit.model, extended, simulated, Stage::kJointAngle, curve.place.joint)
          .col(0),
      Eigen::VectorXd(readings.count())};
  for (Eigen::Index row = 0; row < readings.count(); ++row) {
    const auto trial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].trial);
    result.at[row] = readings.trials()[trial].q[curve.place.joint];
  }
  return result;
}

/// `random`, and the columns of all curves as these readings see them.
Eigen::MatrixXd columns_of(
    const Readings& readings, const JointFit& fit, const std::vector<OwnCurve>& curves,
    const Eigen::MatrixXd& random) {
  Eigen::MatrixXd columns = random;
  columns.conservativeResize(readings.count(), Eigen::NoChange);
  for (const OwnCurve& curve : curves) {
    const Along here = along(readings, fit, curve);
    for (const UnknownCandidate& part : curve.parts) {
      const Eigen::Index before = columns.cols();
      columns.conservativeResize(Eigen::NoChange, before + part.kernel.size.size());
      auto own = columns.rightCols(part.kernel.size.size());
      own.setZero();
      for (Eigen::Index row = 0; row < readings.count(); ++row) {
        if (!std::isfinite(here.at[row])) continue;  // the pose does not exist
        own.row(row) =
            here.per_unit[row] * kernel_values(part.kernel, here.at[row]).transpose();
      }
    }
  }
  return columns;
}

simulation::ActiveEffect effect_of(
    const OwnCurve& curve, const Kernel& kernel, const Eigen::VectorXd& u) {
  const int most = *std::ranges::max_element(kernel.functions);
  std::vector<double> x(simulation::kSmoothHead + static_cast<std::size_t>(most) + 1, 0.0);
  x[0] = kernel.low;
  x[1] = kernel.high;
  x[2] = kernel.half_width;
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const int j = kernel.functions[static_cast<std::size_t>(k)];
    x[simulation::kSmoothHead + static_cast<std::size_t>(j)] = kernel.size[k] * u[k];
  }
  return {curve.effect, curve.place, std::move(x)};
}

}  // namespace

const simulation::Effect* curve_of_dials() {
  const auto rows = simulation::all_effects();
  const auto found = std::ranges::find_if(rows, [](const simulation::Effect* each) {
    return each->is_curve && each->plot.shows == simulation::Shows::kReading;
  });
  return *found;
}

JointFit with_curves(
    const Readings& readings, const JointFit& from, const std::vector<OwnCurve>& curves,
    const Eigen::MatrixXd& random, const std::optional<Eigen::MatrixXd>& kept) {
  if (curves.empty()) return from;
  // A dial's curve goes by what the dial would read, which a fit without the curve has a little
  // wrong; where a joint stood was measured.
  const int passes = std::ranges::any_of(curves, is_of_a_dial) ? 2 : 1;
  JointFit free = from;
  for (int pass = 0; pass < passes; ++pass) {
    free = fit_jointly(
        readings, free.model, free.effects, &free, columns_of(readings, free, curves, random));
  }
  std::vector<simulation::ActiveEffect> effects = free.effects;
  Eigen::Index first = free.known + random.cols();
  for (const OwnCurve& curve : curves) {
    for (const UnknownCandidate& part : curve.parts) {
      const Eigen::Index own = part.kernel.size.size();
      effects.push_back(effect_of(curve, part.kernel, free.u.segment(first, own)));
      first += own;
    }
  }
  return fit_jointly(readings, free.model, std::move(effects), &free, kept.value_or(random));
}

}  // namespace sixdial::diagnosis
