// Readings that are far from what the robot and the named causes say, one by one.
#pragma once

#include <vector>

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

[[nodiscard]] std::vector<GrossReading> gross_readings(
    const Readings& readings, const JointFit& fit);

/// Dials most of whose readings are far off: something is wrong with the dial, and its readings
/// are not listed one by one.
[[nodiscard]] std::vector<bool> wrong_dials(const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
