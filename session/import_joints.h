// Which columns of somebody's table are the joints' values, and of which joint each.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "session/import_guess.h"
#include "session/import_seen.h"
#include "session/sample_layout.h"

namespace sixdial::session {

struct JointTarget {
  std::string to;    // "q1_rad", "theta1_rad", "q3_mm", "q1_command_rad"
  std::string unit;  // "rad" or "mm"
};
/// Of the joint with this index; without a layout it turns.
[[nodiscard]] JointTarget joint_target(
    const SampleLayout* layout, std::size_t joint, bool commanded);

/// Fills guess.columns, .left_out and .open for the joints; columns in use already stay.
void guess_joints(
    const std::vector<SeenColumn>& seen, const SampleLayout* layout, Guess& guess);

}  // namespace sixdial::session
