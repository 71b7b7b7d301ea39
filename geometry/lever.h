// An angle among lengths: it counts as what it moves at the end of a lever. The lever is such
// that an instrument knows both equally well, so that all its channels weigh alike.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

/// Where the instrument states no deviations; and weighs turns against lengths in Newton steps
/// and in what they leave.
inline constexpr double kUsualLever_mm = 500.0;

/// Deviation of the instrument's lengths over that of its angles [mm].
[[nodiscard]] double lever_mm(const InstrumentModel& instrument);

}  // namespace sixdial::geometry
