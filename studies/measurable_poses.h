// Poses that a plan may choose from: a grid of targets in each working mode, those of them that
// the dials can measure.
#pragma once

#include <vector>

#include "diagnosis/separation.h"
#include "session/plan.h"
#include "session/session.h"

namespace sixdial::studies {

/// The rectangle around the session's targets; the default one of `plan grid` where there are
/// none or they span no area.
[[nodiscard]] session::Rectangle rectangle_of(const session::Session& session);

/// Targets in W on a grid over the rectangle, in each of these modes (empty: all of the
/// robot's), with the nominal robot's angles. Neighbours in a row or column are reached from
/// opposite sides. A mode that the middle of the rectangle cannot be reached in gives none.
[[nodiscard]] std::vector<diagnosis::PosePoint> measurable_poses(
    const geometry::Rig& rig, const std::vector<geometry::WorkingMode>& modes,
    const session::Rectangle& rectangle);

}  // namespace sixdial::studies
