// The part of the catalogue that is known when the program is built; effect.h has the whole.
#pragma once

#include <span>

#include "simulation/effect.h"

namespace sixdial::simulation {

/// In alphabetical order of cause.
[[nodiscard]] std::span<const Effect* const> built_in_effects();

}  // namespace sixdial::simulation
