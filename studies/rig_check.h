// sixdial plan rig-check: poses that tell the rig's own geometry (where dials stand, how they
// lean, the cuboid) apart from the robot's, and how much that many poses would tell. Made
// before any session: how well the rig is known is what its file states; where it states
// nothing, a workshop's deviations are taken.
//
// Example:
//   const RigCheck check = rig_check(rig, {.points = 24});
//   check.figures.quantities.front().left;  // share of its standard deviation that stays
#pragma once

#include <string>
#include <vector>

#include "session/plan.h"

namespace sixdial::studies {

struct RigCheckRequest {
  int points = 24;
  /// Working modes to measure in; empty: only that of the rig file.
  std::vector<geometry::WorkingMode> modes{};
  session::Rectangle rectangle{};
};

struct RigCheckQuantity {
  std::string name{};   // "place of dial C across its axis"
  std::string unit{};   // "mm", "deg"
  bool stated = false;  // by the rig file
  double sd = 0.0;      // before: stated, or what a workshop knows
  double left = 0.0;    // share of it that the plan leaves
};

/// What the first `points` points of the plan would tell.
struct RigCheckStage {
  int points = 0;
  double left = 0.0;         // root mean square of the quantities' shares
  double position_mm = 0.0;  // standard deviation of the tool's position, mean over the area
};

struct RigCheckFigures {
  int points = 0;
  std::vector<RigCheckQuantity> quantities{};
  std::vector<RigCheckStage> stages{};
  /// Standard deviation of the tool's position if the rig were exactly as its file says [mm].
  double exact_rig_mm = 0.0;
};

struct RigCheck {
  session::Plan plan;  // G1, working mode by working mode
  RigCheckFigures figures;
};

/// Throws StudyError bad_data where no pose can be measured in these working modes or the rig
/// has no dials.
[[nodiscard]] RigCheck rig_check(const geometry::Rig& rig, const RigCheckRequest& request);

}  // namespace sixdial::studies
