#include "calibration/workspace.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sixdial::calibration {

std::vector<WorkspacePose> workspace_grid(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const geometry::Position& low_mm,
    const geometry::Position& high_mm, int nx, int ny,
    std::span<const geometry::WorkingMode> modes) {
  const auto part = [](int i, int n) {
    return n == 1 ? 0.5 : static_cast<double>(i) / (n - 1);
  };
  std::vector<WorkspacePose> poses;
  for (const geometry::WorkingMode mode : modes) {
    for (int iy = 0; iy < ny; ++iy) {
      for (int ix = 0; ix < nx; ++ix) {
        geometry::Position target = low_mm;
        target[0] += (high_mm[0] - low_mm[0]) * part(ix, nx);
        target[1] += (high_mm[1] - low_mm[1]) * part(iy, ny);
        if (target.size() > 2) target[2] += (high_mm[2] - low_mm[2]) / 2;
        const auto q = tool.inverse(v, target, mode);
        if (!q) continue;
        const auto assembly = tool.assembly_at(v, *q, target);
        if (assembly) poses.push_back({target, *q, *assembly, mode});
      }
    }
  }
  return poses;
}

double position_sd_mm(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& P,
    const WorkspacePose& pose) {
  const auto d = tool.derivative(v, pose.q, pose.assembly);
  if (!d) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt((d->J_v * P * d->J_v.transpose()).trace());
}

WorkspaceUncertainty workspace_uncertainty(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const Eigen::MatrixXd& P,
    std::span<const WorkspacePose> poses) {
  WorkspaceUncertainty result;
  double squares = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double sd = position_sd_mm(tool, v, P, poses[i]);
    if (!std::isfinite(sd)) continue;
    ++result.poses;
    result.mean_mm += sd;
    squares += sd * sd;
    if (sd > result.max_mm) {
      result.max_mm = sd;
      result.worst = i;
    }
  }
  if (result.poses > 0) {
    const auto n = static_cast<double>(result.poses);
    result.mean_mm /= n;
    result.rms_mm = std::sqrt(squares / n);
  }
  return result;
}

}  // namespace sixdial::calibration
