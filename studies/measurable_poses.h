// Poses that a plan may choose from: a grid of targets in each working mode, as far as the rig
// can measure there.
#pragma once

#include <vector>

#include "diagnosis/separation.h"
#include "session/plan.h"
#include "session/session.h"

namespace sixdial::studies {

/// Of the session's targets; that of plan grid where it has none.
[[nodiscard]] session::Rectangle rectangle_of(const session::Session& session);

/// Targets in W on a grid over the rectangle, in each of these modes (empty: all of the
/// robot's), with the nominal robot's angles. Neighbours are reached from opposite sides.
[[nodiscard]] std::vector<diagnosis::PosePoint> measurable_poses(
    const geometry::Rig& rig, const std::vector<geometry::WorkingMode>& modes,
    const session::Rectangle& rectangle);

}  // namespace sixdial::studies
