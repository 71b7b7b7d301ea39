#include "calibration/predicted_position.h"

#include <algorithm>

#include "calibration/reading_space.h"
#include "calibration/rig_errors.h"
#include "calibration/sandwich.h"

namespace sixdial::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

PredictedPosition::PredictedPosition(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    double sigma_mm, const Structure& structure) {
  const Sandwich sandwich = sandwich_of(space, fit, weighting);
  noise_ = sandwich.noise;
  rig_ = moved_by_rig(space, sandwich);
  if (!(structure.sd_mm > 0.0)) {
    parts_.push_back({});
    parts_.back().noise_mm = sigma_mm;
    return;
  }
  for (const StructurePart& each : parts_of(structure)) {
    const Moves moves(space, fit.x, each.acts);
    Part& part = parts_.emplace_back();
    part.weight = each.weight;
    part.sd_mm = each.sd_mm;
    part.noise_mm = each.noise_mm;
    // The first channels of a space of positions are the tool's coordinates.
    part.moves_tool = each.acts == SmoothActs::kTool || shows_position(space);
    part.over_joints = each.over == SmoothOver::kJoints;
    part.basis.emplace_back(space, each.over, each.length);
    part.moved = moved_by(space, sandwich, moves, part.basis.front()(space));
  }
}

MatrixXd PredictedPosition::covariance(const VectorXd& joints, const MatrixXd& J_v) const {
  const Index axes = J_v.rows();
  const Index n = J_v.cols();
  const MatrixXd noise = J_v * noise_.topLeftCorner(n, n) * J_v.transpose();
  ObservationSpace here;
  here.joints = joints;
  here.sample = {0};
  here.first_row = {0, 0};
  const MatrixXd by_rig = J_v * rig_.topRows(n);
  MatrixXd result = by_rig * by_rig.transpose();
  for (const Part& part : parts_) {
    MatrixXd P = part.noise_mm * part.noise_mm * noise;
    if (!part.basis.empty()) {
      MatrixXd off = J_v * part.moved.topRows(n);
      double unseen = part.moves_tool ? 1.0 : 0.0;  // of the structure's variance at this place
      if (part.moves_tool && part.over_joints) {
        const Eigen::RowVectorXd phi = part.basis.front()(here).row(0);
        for (Index axis = 0; axis < axes && (axis + 1) * phi.size() <= off.cols(); ++axis) {
          off.block(axis, axis * phi.size(), 1, phi.size()) -= phi;
        }
        unseen = std::max(0.0, 1.0 - phi.squaredNorm());
      }
      P += part.sd_mm * part.sd_mm *
           (off * off.transpose() + unseen * MatrixXd::Identity(axes, axes));
    }
    result += part.weight * P;
  }
  return result;
}

}  // namespace sixdial::calibration
