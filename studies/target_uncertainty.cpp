#include "studies/target_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "geometry/lever.h"
#include "geometry/tool.h"
#include "studies/calibration_result.h"
#include "studies/compensate.h"

namespace sixdial::studies {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void add_smooth_errors(
    double sd_mm, const geometry::InstrumentModel& instrument, MatrixXd& twist) {
  twist.diagonal().head<3>().array() += sd_mm * sd_mm;
  twist.diagonal().tail<3>().array() += std::pow(sd_mm / geometry::lever_mm(instrument), 2);
}

TargetUncertainty uncertainty_of(const MatrixXd& twist, bool with_turn) {
  const auto root = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  TargetUncertainty result{.position_sd_mm = root(twist.topLeftCorner<3, 3>().trace())};
  if (with_turn) result.turn_sd_rad = root(twist.bottomRightCorner<3, 3>().trace());
  return result;
}

std::optional<TargetUncertainty> target_uncertainty(
    const CalibrationResult& result, const geometry::Rig& rig,
    const CommandedTarget& commanded) {
  const geometry::Tool tool(rig);
  const geometry::RobotModel& robot = tool.robot();
  const MatrixXd& covariance = result.identification.covariance;
  const Index n = robot.parameter_count();
  if (tool.axes() != 3 || commanded.by == CompensateBy::kBefore || covariance.rows() != n ||
      covariance.cols() != n || !covariance.allFinite()) {
    return std::nullopt;
  }
  const VectorXd v = result.identified();
  const auto q =
      Eigen::Map<const VectorXd>(commanded.theta_rad.data(), std::ssize(commanded.theta_rad));
  const geometry::Position there =
      result.frame ? geometry::Position((*result.frame)(commanded.target_mm))
                   : commanded.target_mm;
  const auto assembly = tool.assembly_at(v, q, there);
  geometry::Frames at(robot);
  at.tool_only = true;
  if (!assembly || !robot.forward_derivative(v, q, *assembly, at)) return std::nullopt;
  MatrixXd twist = at.by_v[0] * covariance * at.by_v[0].transpose();
  if (result.assessment) {
    // Smooth errors that the parameters lack move the tool itself as much.
    add_smooth_errors(result.assessment->structure.sd_mm, *geometry::instrument_of(rig), twist);
  }
  return uncertainty_of(twist, commanded.turn.has_value());
}

}  // namespace sixdial::studies
