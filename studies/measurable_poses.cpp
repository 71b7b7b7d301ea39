#include "studies/measurable_poses.h"

#include "geometry/tool.h"

namespace sixdial::studies {
namespace {

constexpr int kGridLines = 13;  // along each side, in each working mode

}  // namespace

session::Rectangle rectangle_of(const session::Session& session) {
  Eigen::Vector2d low(1e300, 1e300);
  Eigen::Vector2d high = -low;
  for (const session::Sample& sample : session.samples) {
    if (!sample.target_mm) continue;
    low = low.cwiseMin(*sample.target_mm);
    high = high.cwiseMax(*sample.target_mm);
  }
  session::Rectangle result;
  if (!(low.array() < high.array()).all()) return result;
  result.min_mm = low;
  result.max_mm = high;
  return result;
}

std::vector<diagnosis::PosePoint> measurable_poses(
    const geometry::Rig& rig, const std::vector<geometry::WorkingMode>& modes,
    const session::Rectangle& rectangle) {
  std::vector<geometry::WorkingMode> wanted = modes;
  if (wanted.empty()) {
    for (const geometry::BranchInfo& each : rig.robot.model->modes) {
      wanted.emplace_back(each.number);
    }
  }
  const geometry::Tool tool(rig);
  std::vector<diagnosis::PosePoint> result;
  for (const geometry::WorkingMode mode : wanted) {
    const auto home = tool.inverse(rig.robot.nominal, rig.cuboid.reference_pose_mm, mode);
    if (!home) continue;
    for (int i = 0; i < kGridLines; ++i) {
      for (int j = 0; j < kGridLines; ++j) {
        const Eigen::Vector2d share(
            static_cast<double>(i) / (kGridLines - 1),
            static_cast<double>(j) / (kGridLines - 1));
        const Eigen::Vector2d exact =
            rectangle.min_mm + share.cwiseProduct(rectangle.max_mm - rectangle.min_mm);
        const Eigen::Vector2d target = (exact * 1e6).array().round() / 1e6;
        const auto q = session::measurable(
            rig, target, mode, session::PlanOptions{}.robot_error_mm, *home);
        if (!q) continue;
        const auto assembly = tool.assembly_at(rig.robot.nominal, *q, target);
        if (!assembly) continue;
        const Eigen::Vector2d rounded = (*q * 1e9).array().round() / 1e9;
        // The side of arrival is part of the question for backlash and its like.
        const int side = (i + j) % 2 == 0 ? 1 : -1;
        result.push_back({rounded, target, *assembly, {side, side}});
      }
    }
  }
  return result;
}

}  // namespace sixdial::studies
