#include "diagnosis/explained_positions.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/judging.h"
#include "diagnosis/thresholds.h"
#include "diagnosis/tool_shift.h"

namespace sixdial::diagnosis {
namespace {

/// The reading of a trial that is furthest from what the others say, where that is further than
/// a good reading is; -1: none.
Eigen::Index odd_one(
    const Readings& readings, const JointFit& here, const ToolColumns& columns,
    Eigen::Index first, Eigen::Index rows, const Eigen::VectorXd& weight, double noise_mm) {
  // Two coordinates and a turn take three readings.
  constexpr double kToSpare = 1.5;
  const Eigen::Index axes = readings.axes();
  if (weight.segment(first, rows).sum() < static_cast<double>(axes) + 1.0 + kToSpare) return -1;
  const bool turns = columns.turn.size() > 0;
  Eigen::MatrixXd A(rows, axes + (turns ? 1 : 0));
  A.leftCols(axes) = columns.shift.middleRows(first, rows);
  constexpr double kLever_mm = 40.0;
  if (turns) A.col(axes) = columns.turn.segment(first, rows) / kLever_mm;
  Eigen::Index worst = -1;
  double most = kGrossSigma * noise_mm;
  for (Eigen::Index row = 0; row < rows; ++row) {
    if (weight[first + row] <= 0) continue;
    Eigen::VectorXd root = weight.segment(first, rows).cwiseSqrt();
    root[row] = 0.0;
    const Eigen::VectorXd others =
        (root.asDiagonal() * A)
            .colPivHouseholderQr()
            .solve(root.cwiseProduct(here.residual_mm.segment(first, rows)));
    const Eigen::VectorXd left = here.residual_mm.segment(first, rows) - A * others;
    const double rest = root.cwiseProduct(left).cwiseAbs().maxCoeff();
    const double relative = readings.relative_noise()[first + row];
    // Leaving it out must make the others agree.
    if (std::abs(left[row]) / relative > most && rest < std::abs(left[row]) / kGrossSigma) {
      most = std::abs(left[row]) / relative;
      worst = first + row;
    }
  }
  return worst;
}

}  // namespace

Eigen::MatrixXd explained_positions(
    const Readings& readings, const simulation::ModelVector& model,
    const std::vector<simulation::ActiveEffect>& effects, double noise_mm) {
  JointFit fit;
  fit.model = model;
  fit.effects = effects;
  fit.s_mm = std::max(noise_mm, readings.rig_noise_mm());
  const JointFit here = applied(readings, fit);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(readings.count());
  const ToolColumns columns = tool_columns(readings, here);
  const auto& trials = readings.trials();
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const Eigen::Index first = readings.first_row(t);
    const Eigen::Index rows = readings.first_row(t + 1) - first;
    if (rows == 0 || !here.residual_mm.segment(first, rows).allFinite()) continue;
    const Eigen::Index odd = odd_one(readings, here, columns, first, rows, weight, fit.s_mm);
    if (odd >= 0) weight[odd] = 0.0;
  }
  Eigen::MatrixXd position = tool_shift(readings, here, here.residual_mm, weight);
  const simulation::ExtendedModel extended(readings.model(), effects);
  for (std::size_t t = 0; t < trials.size(); ++t) {
    simulation::Scene scene;
    const auto ran = extended.run(model, trials[t], readings.circumstances()[t], scene);
    if (ran) {
      position.col(static_cast<Eigen::Index>(t)) += scene.p_WE.head(readings.axes());
    } else {
      position.col(static_cast<Eigen::Index>(t))
          .setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return position;
}

}  // namespace sixdial::diagnosis
