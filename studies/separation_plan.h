// sixdial plan separate: the poses that would tell two tied causes apart, or make visible an
// effect that this session cannot show, as a plan that is ready to be collected.
#pragma once

#include <string>
#include <vector>

#include "session/plan.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

struct SeparationRequest {
  int points = 24;
  /// Working modes to measure in; empty: all that can be measured.
  std::vector<geometry::WorkingMode> modes;
};

struct SeparationPlan {
  session::Plan plan;  // G1, numbered after the session's, working mode by working mode
  /// {separates [{cause, where}], rival (null: against nothing), size_assumed, log_odds_now,
  /// log_odds_after, points, by_point [{target_mm, mode, log_odds}]}.
  Json words;
};

/// Diagnoses the session and takes its first tied set; without one, the effect that it is
/// blindest to, at a plausible size. Throws Error bad_data where there are too few readings or
/// no pose can be measured.
[[nodiscard]] SeparationPlan separation_plan(
    const session::Session& session, const SeparationRequest& request);

/// For people: what comes apart, and how surely.
[[nodiscard]] std::string separation_text(const Json& words);

}  // namespace sixdial::studies
