#include "session/plan_in_space.h"

#include <fmt/format.h>

#include <utility>

#include "geometry/long_work.h"
#include "session/planner_in_space.h"

namespace sixdial::session {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// [[joint]] rows as rig.toml has them.
std::vector<geometry::FileValue::Table> joint_rows(const geometry::Rig& rig) {
  const geometry::RobotModel& robot = *rig.robot.model;
  if (robot.kind->to_file == nullptr) return {};
  return robot.kind->to_file(robot, rig.robot.nominal).joints;
}

}  // namespace

bool lists_its_joints(const geometry::Rig& rig) { return !joint_rows(rig).empty(); }

bool lacks_ranges(const geometry::Rig& rig) {
  for (const geometry::FileValue::Table& row : joint_rows(rig)) {
    bool low = false;
    bool high = false;
    for (const auto& [key, value] : row) {
      low = low || key.starts_with("low_");
      high = high || key.starts_with("high_");
    }
    if (!row.contains("follows") && !(low && high)) return true;
  }
  return false;
}

tl::expected<DrawnPoses, PlanRefusal> drawn_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, const std::optional<TargetBox>& box,
    int count, Uniform& random) {
  const PlannerInSpace planner(rig, mode);
  if (!box && !planner.listed()) {
    return tl::unexpected(refusal_of(
        Position::Zero(rig.instrument.dimensions),
        fmt::format(
            "rig.toml does not say which joint values this {} takes",
            rig.robot.model->kind->in_words),
        "say in which box to measure: sixdial plan random ... --box x0 y0 z0 x1 y1 z1"));
  }
  DrawnPoses drawn;
  const std::int64_t most_draws = std::int64_t{kMostDrawsPerPoint} * count;
  while (std::ssize(drawn.poses) < count && drawn.draws < most_draws) {
    geometry::check_end();
    ++drawn.draws;
    const VectorXd q = planner.listed() ? planner.drawn_joints(random) : VectorXd();
    TriedPose tried;
    if (box) {
      Vector3d target;
      for (Index k = 0; k < 3; ++k) {
        target[k] = box->min_mm[k] + random.next() * (box->max_mm[k] - box->min_mm[k]);
      }
      tried = planner.as_it_comes(target, q);
    } else {
      tried = planner.of_joints(q);
    }
    if (tried.pose) {
      drawn.poses.push_back(*std::move(tried.pose));
    } else {
      drawn.last_mm = tried.target_mm;
      drawn.why = std::move(tried.why);
    }
  }
  return drawn;
}

tl::expected<void, PlanRefusal> add_grid_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, int nx, int ny,
    const PlanOptions& options, std::vector<PlanPose>& poses) {
  const auto refuse = [](const TriedPose& tried, const std::string& where) {
    return tl::unexpected(refusal_of(
        tried.target_mm, where + tried.why, "choose a smaller box, or plan random points"));
  };
  const PlannerInSpace planner(rig, mode);
  const Vector3d low = options.box->min_mm;
  const Vector3d size = options.box->max_mm - low;
  const TriedPose middle = planner.with_most_room(low + size / 2);
  if (!middle.pose) return refuse(middle, "in the middle of the box: ");
  const auto part = [](int i, int n) {
    return n == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(n - 1);
  };
  int row = 0;
  for (int iz = 0; iz < options.nz; ++iz) {
    for (int iy = 0; iy < ny; ++iy, ++row) {
      for (int step = 0; step < nx; ++step) {
        geometry::check_end();
        const int ix = row % 2 == 0 ? step : nx - 1 - step;
        const Vector3d share(part(ix, nx), part(iy, ny), part(iz, options.nz));
        TriedPose tried = planner.turned_as(low + size.cwiseProduct(share), middle.pose->q);
        if (!tried.pose) return refuse(tried, "");
        poses.push_back(*std::move(tried.pose));
      }
    }
  }
  return {};
}

}  // namespace sixdial::session
