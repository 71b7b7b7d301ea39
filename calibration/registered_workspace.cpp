#include "calibration/registered_workspace.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "geometry/rotation.h"

namespace sixdial::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

RegisteredWorkspace::RegisteredWorkspace(
    const geometry::Tool& tool, const Eigen::VectorXd& v, std::span<const WorkspacePose> poses)
    : parameters_(v.size()) {
  std::vector<Vector3d> places;
  for (const WorkspacePose& pose : poses) {
    const auto d = tool.derivative(v, pose.q, pose.assembly);
    if (!d) continue;
    J_.push_back(d->J_v);
    places.emplace_back(d->p_WE);
  }
  if (J_.empty()) return;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& place : places) middle += place / static_cast<double>(places.size());
  const auto rows = 3 * static_cast<Index>(J_.size());
  MatrixXd all(rows, parameters_);
  MatrixXd motions(rows, 6);
  for (std::size_t k = 0; k < J_.size(); ++k) {
    const auto row = 3 * static_cast<Index>(k);
    all.middleRows(row, 3) = J_[k];
    motions.block<3, 3>(row, 0).setIdentity();
    motions.block<3, 3>(row, 3) = -geometry::skew<double>(places[k] - middle);
  }
  all -= motions * motions.completeOrthogonalDecomposition().solve(all);
  for (std::size_t k = 0; k < J_.size(); ++k) {
    J_[k] = all.middleRows(3 * static_cast<Index>(k), 3);
  }
}

WorkspaceUncertainty RegisteredWorkspace::uncertainty(const MatrixXd& P) const {
  WorkspaceUncertainty result;
  double squares = 0.0;
  for (std::size_t k = 0; k < J_.size(); ++k) {
    const double variance = (J_[k] * P * J_[k].transpose()).trace();
    const double sd = std::sqrt(std::max(0.0, variance));
    result.mean_mm += sd;
    squares += variance;
    if (sd > result.max_mm) {
      result.max_mm = sd;
      result.worst = k;
    }
  }
  result.poses = J_.size();
  if (J_.empty()) return result;
  result.mean_mm /= static_cast<double>(J_.size());
  result.rms_mm = std::sqrt(std::max(0.0, squares) / static_cast<double>(J_.size()));
  return result;
}

MatrixXd RegisteredWorkspace::mean_sensitivity() const {
  MatrixXd mean = MatrixXd::Zero(parameters_, parameters_);
  for (const MatrixXd& J : J_) mean += J.transpose() * J;
  return J_.empty() ? mean : MatrixXd(mean / static_cast<double>(J_.size()));
}

}  // namespace sixdial::calibration
