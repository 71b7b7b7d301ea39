// The rig as a drawing, from the numbers of its rig file: table frame W, robot frame B, motors,
// links at the reference pose, cuboid, and each dial with its name where it stands.
#pragma once

#include <string>

#include "geometry/rig.h"
#include "report/document.h"

namespace sixdial::report {

/// A whole SVG document, in millimetres of the table frame, y upwards. What cannot be drawn (a
/// reference pose out of reach) is said in the picture. All text of the file is escaped.
[[nodiscard]] std::string rig_svg(const geometry::Rig& rig);
/// The picture as a section of a report, with the same numbers as a table.
[[nodiscard]] Section rig_section(const geometry::Rig& rig);

}  // namespace sixdial::report
