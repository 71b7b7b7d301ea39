// The normal equations of all measured positions for one robot, eight samples at a time: what
// Levenberg-Marquardt needs for a step, without ever storing the Jacobian.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/five_bar/positions.h"
#include "calibration/lanes.h"
#include "geometry/robots/five_bar.h"

namespace sixdial::calibration {

/// Eight samples, lane by lane. The last block of a session is filled up with samples of weight
/// 0.
struct PositionBlock {
  double cos1[kLanes], sin1[kLanes], cos2[kLanes], sin2[kLanes];  // of the encoder angles
  double beta[kLanes];
  double x_mm[kLanes], y_mm[kLanes];  // measured
  double weight[kLanes];
};

[[nodiscard]] std::vector<PositionBlock> position_blocks(
    const PositionObservations& observations);

/// J'J (lower triangle, 10x10), J'r (10) and r'r with r = predicted - measured [mm]. False
/// where a pose cannot be reached or a number is not finite.
[[nodiscard]] bool position_normal(
    const std::vector<PositionBlock>& blocks, const geometry::ParameterVector& v,
    Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr, double& rss_mm2);

}  // namespace sixdial::calibration
