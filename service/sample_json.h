// A sample as it goes over the socket: raw readings with their quality, and where they put the
// tool.
#pragma once

#include <string>

#include "service/error.h"
#include "session/session.h"

namespace sixdial::service {

/// set, point, repeat, time_utc, each joint by its column (q1_rad, q2_mm ...), target_mm,
/// approach, temperature_c, dials {id: {value_mm, quality, reason}}, readings_within_ms (from
/// the first to the last dial's answer; null: no times), position_mm and gamma_rad (null:
/// contacts allow none).
[[nodiscard]] Json sample_json(const geometry::Rig& rig, const session::Sample& sample);

/// What makes a stored sample worth another look: a doubtful dial, no position. Empty: nothing.
[[nodiscard]] std::string doubt_of(const geometry::Rig& rig, const session::Sample& sample);

}  // namespace sixdial::service
