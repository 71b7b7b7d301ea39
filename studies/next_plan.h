// sixdial plan next: the poses that make the tool's position over the workspace best known,
// given what a session has told so far, as a plan that is ready to be collected.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/design.h"
#include "session/plan.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

struct NextPlanRequest {
  int points = 10;
  calibration::Criterion criterion = calibration::Criterion::kI;
  /// Working modes to measure in; empty: those of the session, else the rig's.
  std::vector<geometry::WorkingMode> modes;
  /// Where poses are taken from; empty: the rectangle of the session's targets, else that of
  /// plan grid.
  std::optional<session::Rectangle> rectangle;
};

struct NextPlan {
  session::Plan plan;  // G1, numbered after the session's, working mode by working mode
  /// {samples, points, criterion, now {mean_mm, max_mm}, after {mean_mm, max_mm}, steps
  /// [{target_mm, mode, mean_mm, max_mm}] in the order chosen}.
  Json words;
};

/// Throws Error bad_data where no pose can be measured in a working mode, naming it.
[[nodiscard]] NextPlan next_plan(
    const session::Session& session, const NextPlanRequest& request);

/// One stretch for each branch, in the order of their first points, so that the legs change
/// over as seldom as can be; points numbered from `first`.
void order_by_branch(const geometry::Rig& rig, session::Plan& plan, int first);

/// "12 samples of G1: ... after these 10: ...".
[[nodiscard]] std::string next_plan_text(const Json& words);

}  // namespace sixdial::studies
