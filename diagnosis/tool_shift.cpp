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

Eigen::Matrix2Xd tool_shift(
    const Readings& readings, const JointFit& fit, const Eigen::VectorXd& residual_mm,
    const Eigen::VectorXd& weight) {
  const ToolColumns columns = tool_columns(readings, fit);
  const std::size_t trials = readings.trials().size();
  Eigen::Matrix2Xd shift =
      Eigen::Matrix2Xd::Constant(2, static_cast<Eigen::Index>(trials), kNan);
  for (std::size_t t = 0; t < trials; ++t) {
    const Eigen::Index first = readings.first_row(t);
    const Eigen::Index rows = readings.first_row(t + 1) - first;
    if (rows < 2 || !residual_mm.segment(first, rows).allFinite()) continue;
    const Eigen::VectorXd root =
        weight.segment(first, rows)
            .cwiseSqrt()
            .cwiseQuotient(readings.relative_noise().segment(first, rows));
    const bool turns = columns.turn.size() > 0 && rows >= 3;
    Eigen::MatrixXd A(rows, turns ? 3 : 2);
    A.leftCols(2) = columns.shift.middleRows(first, rows);
    // A turn in units that move a face by about as much as a shift does.
    constexpr double kLever_mm = 40.0;
    if (turns) A.col(2) = columns.turn.segment(first, rows) / kLever_mm;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(root.asDiagonal() * A);
    qr.setThreshold(1e-3);
    if (qr.rank() < A.cols()) {
      qr.compute(root.asDiagonal() * A.leftCols(2));
      if (qr.rank() < 2) continue;
    }
    shift.col(static_cast<Eigen::Index>(t)) =
        qr.solve(root.cwiseProduct(residual_mm.segment(first, rows))).head<2>();
  }
  return shift;
}

}  // namespace sixdial::diagnosis
