// sixdial plan next: the poses that make the tool's position over the workspace best known,
// given what a session has told so far, as a plan that is ready to be collected.
//
// Example:
//   const NextPlan next = next_plan(session, {.points = 3});
//   next.plan.points.size();  // -> 3U
//   next.figures.after->max_mm < next.figures.now.max_mm;  // -> true
#pragma once

#include <optional>
#include <vector>

#include "calibration/design.h"
#include "session/plan.h"
#include "session/session.h"

namespace sixdial::studies {

struct NextPlanRequest {
  int points = 10;
  calibration::Criterion criterion = calibration::Criterion::kI;
  /// Working modes to measure in; empty: those of the session, else the rig's.
  std::vector<geometry::WorkingMode> modes{};
  /// Where poses of a robot in the plane are taken from; empty: the rectangle of the session's
  /// targets, else that of plan grid. Of a robot in space: the box of the session's targets,
  /// else the ranges of its joints.
  std::optional<session::Rectangle> rectangle{};
};

/// Standard deviation of the tool's position over the workspace.
struct PositionSd {
  double mean_mm = 0.0;
  double max_mm = 0.0;
};

/// A pose of the plan, and what would be known once it and those before it are measured.
struct NextStep {
  geometry::Position target_mm;
  geometry::WorkingMode mode{};
  PositionSd after{};
};

/// What a plan is worth: what the session's samples tell, and what they would tell with it.
struct NextPlanFigures {
  int samples = 0;  // of G1, so far
  int points = 0;   // of the plan
  calibration::Criterion criterion = calibration::Criterion::kI;
  PositionSd now{};
  std::optional<PositionSd> after{};  // empty: no point could be added
  std::vector<NextStep> steps{};      // in the order chosen
};

struct NextPlan {
  session::Plan plan;  // G1, numbered after the session's, working mode by working mode
  NextPlanFigures figures;
};

/// Throws StudyError bad_data where no pose can be measured in a working mode, naming it.
[[nodiscard]] NextPlan next_plan(
    const session::Session& session, const NextPlanRequest& request);

/// Sorts the points by branch, in the order in which the branches appear, so that the legs
/// change over as seldom as possible; numbers the points from `first` on.
void order_by_branch(const geometry::Rig& rig, session::Plan& plan, int first);

}  // namespace sixdial::studies
