// Which shifts the readings of an arrival could share: of the tool, whose place a robot does
// not repeat, or of the joints, whose recorded values are not where they stood.
#pragma once

#include <memory>
#include <vector>

#include "diagnosis/readings.h"

namespace sixdial::diagnosis {

/// All that this session could tell, with the robot at `at`. Without dials a shift of the tool
/// is not to be told from each reading's own noise, which is as large in all poses; scatter of
/// the joint values is, as it moves the tool more in some poses and directions than in others.
/// Empty where too few readings are left over.
[[nodiscard]] std::vector<std::shared_ptr<const ScatterColumns>> shareable_columns(
    const Readings& readings, const simulation::ModelVector& at);

/// What a shift of one unit in each shared direction moves the tool by, root mean square of one
/// coordinate [mm].
[[nodiscard]] double tool_motion_mm(
    const Readings& readings, const simulation::ModelVector& at, ScatterOf of);

}  // namespace sixdial::diagnosis
