// The joints of a robot in space that err each by its own angle, looked for before any name.
#pragma once

#include <vector>

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// Where three joints or more each err by their own angle, as the drives of a real arm do:
/// their curves, found before any name. One by one they would pass for many small causes. Empty
/// otherwise, and in the plane.
[[nodiscard]] std::vector<JointCurve> find_joint_curves(
    const Readings& readings, const NamingSettings& settings);

}  // namespace sixdial::diagnosis
