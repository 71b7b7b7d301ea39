// An angle among lengths: it counts as what it moves at the end of a lever. The lever is such
// that an instrument knows both equally well, so that all its channels weigh alike.
#pragma once

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {

/// Of angles that nobody knows the deviation of, and of turns in closures and steps.
inline constexpr double kUsualLever_mm = 500.0;

/// Deviation of the instrument's lengths over that of its angles [mm].
[[nodiscard]] double lever_mm(const InstrumentModel& instrument);

}  // namespace sixdial::geometry
