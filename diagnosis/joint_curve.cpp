#include "diagnosis/joint_curve.h"

#include <algorithm>
#include <utility>

#include "diagnosis/stages.h"
#include "simulation/smooth_function.h"

namespace sixdial::diagnosis {
namespace {

/// A part of a curve as these readings see it.
Eigen::MatrixXd columns_of(
    const Readings& readings, const Eigen::MatrixXd& stage, const UnknownCandidate& part,
    int joint) {
  Eigen::MatrixXd columns(readings.count(), part.kernel.size.size());
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    const auto trial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(row)].trial);
    columns.row(row) =
        stage(row, 0) *
        kernel_values(part.kernel, readings.trials()[trial].q[joint]).transpose();
  }
  return columns;
}

simulation::ActiveEffect effect_of(
    const JointCurve& curve, const Kernel& kernel, const Eigen::VectorXd& u) {
  const int most = *std::ranges::max_element(kernel.functions);
  std::vector<double> x(simulation::kSmoothHead + static_cast<std::size_t>(most) + 1, 0.0);
  x[0] = kernel.low;
  x[1] = kernel.high;
  x[2] = kernel.half_width;
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const int j = kernel.functions[static_cast<std::size_t>(k)];
    x[simulation::kSmoothHead + static_cast<std::size_t>(j)] = kernel.size[k] * u[k];
  }
  return {simulation::curve_of_joints(), curve.place, std::move(x)};
}

}  // namespace

JointFit with_joint_curves(
    const Readings& readings, const JointFit& from, const std::vector<JointCurve>& curves,
    const Eigen::MatrixXd& random) {
  if (curves.empty()) return from;
  const simulation::ExtendedModel extended(readings.model(), from.effects);
  const Eigen::VectorXd simulated = readings.simulate(from.model, extended);
  Eigen::MatrixXd columns = random;
  columns.conservativeResize(readings.count(), Eigen::NoChange);
  for (const JointCurve& curve : curves) {
    const Eigen::MatrixXd stage = stage_columns(
        readings, from.model, extended, simulated, Stage::kJointAngle, curve.place.joint);
    for (const UnknownCandidate& part : curve.parts) {
      const Eigen::Index before = columns.cols();
      columns.conservativeResize(Eigen::NoChange, before + part.kernel.size.size());
      columns.rightCols(part.kernel.size.size()) =
          columns_of(readings, stage, part, curve.place.joint);
    }
  }
  const JointFit free = fit_jointly(readings, from.model, from.effects, &from, columns);
  std::vector<simulation::ActiveEffect> effects = free.effects;
  Eigen::Index first = free.known + random.cols();
  for (const JointCurve& curve : curves) {
    for (const UnknownCandidate& part : curve.parts) {
      const Eigen::Index own = part.kernel.size.size();
      effects.push_back(effect_of(curve, part.kernel, free.u.segment(first, own)));
      first += own;
    }
  }
  return fit_jointly(readings, free.model, std::move(effects), &free, random);
}

}  // namespace sixdial::diagnosis
