// rig.toml: the measurement rig as a file people write (doc/manual/files.md). Lengths in mm,
// angles in degrees.
//
//   name, tolerance_mm
//   [robot]   model, working_mode, assembly, l11_mm ... d_mm, x0_mm, y0_mm, alpha_deg,
//             theta1_offset_deg, theta2_offset_deg, connection; [[joint]] rows of an arm
//   [cuboid]  side_mm, mount ("distal1", "distal2", "free"), reference_pose_mm
//   [dials]   travel_mm, resolution_mm, accuracy_mm, repeatability_mm, tip_radius_mm, force_n,
//             spring_n_per_mm, connection: common to all dials
//   [[dial]]  id, position_mm, axis, and any key of [dials] to override it
//   [instrument] and its places: what measures instead of dials (doc/robots.md)
//   How well all that is known: rig_deviations.h. operator, certificates: traceability.h.
//
// Optional: name, tolerance_mm, model, connection, accuracy_mm, force_n, spring_n_per_mm, mount
// (distal2), reference_pose_mm of a free mount, all dials of a rig that only takes positions.
//
// Example:
//   const geometry::Rig again = parse_rig(write_rig(rig), "rig.toml");
//   again.dials.size();  // -> 6U
//   again.robot.nominal;  // -> rig.robot.nominal
#pragma once

#include <string>
#include <string_view>

#include "geometry/rig.h"
#include "session/data_error.h"

namespace sixdial::session {

/// Throws DataError with line and column for a key that is unknown, missing, of the wrong type
/// or without sense. An axis within 1e-3 of unit length is made a unit vector.
[[nodiscard]] geometry::Rig parse_rig(std::string_view text, const std::string& file_name);

/// parse_rig of the file's text.
[[nodiscard]] geometry::Rig read_rig_file(const std::string& path);

/// Text that parse_rig reads back equal. The one exception: an angle [rad] of which no double
/// in degrees is the exact image comes back to its last bit.
[[nodiscard]] std::string write_rig(const geometry::Rig& rig);

/// The tables of that text which say what measures, [instrument] and its places; empty of dials
/// on a cuboid alone.
[[nodiscard]] std::string instrument_text(const geometry::Rig& rig);

}  // namespace sixdial::session
