#include "diagnosis/tool_shift.h"

#include <Eigen/Dense>
#include <limits>

#include "diagnosis/stages.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

ToolColumns tool_columns(const Readings& readings, const JointFit& fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  ToolColumns result{stage_columns(readings, fit.model, extended, simulated, Stage::kTool), {}};
  if (readings.has_dials()) {
    result.turn =
        stage_columns(readings, fit.model, extended, simulated, Stage::kCuboidAngle).col(0);
  }
  return result;
}

Eigen::MatrixXd tool_shift(
    const Readings& readings, const JointFit& fit, const Eigen::VectorXd& residual_mm,
    const Eigen::VectorXd& weight) {
  const ToolColumns columns = tool_columns(readings, fit);
  const std::size_t trials = readings.trials().size();
  const Eigen::Index axes = readings.axes();
  Eigen::MatrixXd shift =
      Eigen::MatrixXd::Constant(axes, static_cast<Eigen::Index>(trials), kNan);
  for (std::size_t t = 0; t < trials; ++t) {
    const Eigen::Index first = readings.first_row(t);
    const Eigen::Index rows = readings.first_row(t + 1) - first;
    if (rows < axes || !residual_mm.segment(first, rows).allFinite()) continue;
    const Eigen::VectorXd root =
        weight.segment(first, rows)
            .cwiseSqrt()
            .cwiseQuotient(readings.relative_noise().segment(first, rows));
    const bool turns = columns.turn.size() > 0 && rows > axes;
    Eigen::MatrixXd A(rows, axes + (turns ? 1 : 0));
    A.leftCols(axes) = columns.shift.middleRows(first, rows);
    // A turn in units that move a face by about as much as a shift does.
    constexpr double kLever_mm = 40.0;
    if (turns) A.col(axes) = columns.turn.segment(first, rows) / kLever_mm;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * A);
    qr.setThreshold(1e-3);
    if (qr.rank() < A.cols()) {
      qr.compute(root.asDiagonal() * A.leftCols(axes));
      if (qr.rank() < axes) continue;
    }
    shift.col(static_cast<Eigen::Index>(t)) =
        qr.solve(root.cwiseProduct(residual_mm.segment(first, rows))).head(axes);
  }
  return shift;
}

}  // namespace sixdial::diagnosis
