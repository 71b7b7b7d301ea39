// sixdial plan separate: the poses that would tell two tied causes apart, or make visible an
// effect that this session cannot show, as a plan that is ready to be collected.
//
// Example:
//   const SeparationPlan apart = separation_plan(session, {.points = 4});
//   show(apart.figures.separates.cause, apart.figures.log_odds_after);
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/plan.h"
#include "session/session.h"

namespace sixdial::studies {

struct SeparationRequest {
  int points = 24;
  /// Working modes to measure in; empty: all that can be measured.
  std::vector<geometry::WorkingMode> modes{};
};

struct PlacedCause {
  std::string cause{};  // "joint_backlash"
  std::string where{};  // "joint 2"
};

struct SeparationPoint {
  Eigen::Vector2d target_mm{0, 0};
  geometry::WorkingMode mode{};
  double log_odds = 0.0;  // expected with this point and those before it
};

/// What comes apart, and how surely. Log odds: natural, of the true cause against its rival.
struct SeparationFigures {
  PlacedCause separates{};
  std::optional<PlacedCause> rival{};    // empty: against no effect at all
  std::optional<double> size_assumed{};  // where the session does not show the effect
  std::string unit{};                    // of size_assumed
  int points = 0;                        // of the plan
  double log_odds_now = 0.0;
  double log_odds_after = 0.0;
  std::vector<SeparationPoint> by_point{};
};

struct SeparationPlan {
  session::Plan plan;  // G1, numbered after the session's, working mode by working mode
  SeparationFigures figures;
};

/// Diagnoses the session and plans for its first set of tied causes; if there is none, for the
/// effect that the session shows worst, at a plausible size. Throws StudyError bad_data where
/// there are too few readings or no pose can be measured.
[[nodiscard]] SeparationPlan separation_plan(
    const session::Session& session, const SeparationRequest& request);

}  // namespace sixdial::studies
