// How well a session's dials tell a position.
#pragma once

#include <optional>

#include "session/session.h"

namespace sixdial::studies {

/// Root of the mean trace of the covariance of a position [mm], from the dials alone; empty:
/// the session has no position that dials gave.
[[nodiscard]] std::optional<double> position_noise_mm(const session::Session& session);

}  // namespace sixdial::studies
