// Poses of robots that work in space: from the ranges of their joints, or in a box through the
// kind's inverse.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "session/plan.h"
#include "session/plan_draw.h"

namespace sixdial::session {

struct PlanPose {
  Position target_mm;  // where the nominal robot has its tool, rounded as a plan file has it
  Eigen::VectorXd q;
};

[[nodiscard]] bool works_in_space(const geometry::Rig& rig);

/// Whether rig.toml lists the joints, so that their ranges are this robot's. Of other kinds
/// (deltas, hexapods) they are those of a typical robot.
[[nodiscard]] bool lists_its_joints(const geometry::Rig& rig);
/// Whether it lists them, some without a low or a high: their ranges are the usual ones.
[[nodiscard]] bool lacks_ranges(const geometry::Rig& rig);

struct DrawnPoses {
  std::vector<PlanPose> poses;
  std::int64_t draws = 0;
  Position last_mm;  // of the last draw that was no good
  std::string why;   // it was not
};

/// Up to `count` poses: uniform over the ranges of the joints, or with their targets uniform
/// over the box. Refused where neither can be drawn from.
[[nodiscard]] tl::expected<DrawnPoses, PlanRefusal> drawn_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, const std::optional<TargetBox>& box,
    int count, Uniform& random);

/// nx x ny x options.nz targets over the box, back and forth, the tool turned as in the box's
/// middle; options.box is there. Refused at the first that the robot cannot take; the poses
/// before it are added.
[[nodiscard]] tl::expected<void, PlanRefusal> add_grid_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, int nx, int ny,
    const PlanOptions& options, std::vector<PlanPose>& poses);

}  // namespace sixdial::session
