// From which side a plan reaches its points where nobody says it.
#pragma once

#include "session/plan.h"

namespace sixdial::session {

/// A controller: as it comes. A person, who can be told: from one side and the other in turn,
/// so that the session shows backlash and knows the side of every sample.
[[nodiscard]] inline ApproachRule usual_approach(const geometry::Rig& rig) {
  return rig.robot.connection == "manual" ? ApproachRule::kAlternate : ApproachRule::kAsItComes;
}

}  // namespace sixdial::session
