// Readings that are far from what the robot and the named causes say, one by one.
#pragma once

#include <vector>

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

[[nodiscard]] std::vector<GrossReading> gross_readings(
    const Readings& readings, const JointFit& fit);

}  // namespace sixdial::diagnosis
