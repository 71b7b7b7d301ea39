// Which shifts the readings of an arrival could share: of the tool, whose place a robot does
// not repeat, or of the joints, whose recorded values are not where they stood.
#pragma once

#include <memory>
#include <vector>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

/// All that this session could tell, with the robot at `at`. Empty where it has positions
/// instead of dials, of which the shared part is not to be told from each one's own; and where
/// too few dials touch.
[[nodiscard]] std::vector<std::shared_ptr<const ScatterColumns>> shareable_columns(
    const Readings& readings, const simulation::ModelVector& at);

/// What a shift of one unit in each shared direction moves the tool by, root mean square of one
/// coordinate [mm].
[[nodiscard]] double tool_motion_mm(
    const Readings& readings, const simulation::ModelVector& at, ScatterOf of);

}  // namespace sixdial::diagnosis
