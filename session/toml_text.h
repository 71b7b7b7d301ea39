// What must be looked at in TOML text before toml++ may see it.
#pragma once

#include <optional>
#include <string_view>

#include "session/data_error.h"

namespace sixdial::session {

/// The first character that is not ASCII outside quotes and comments. TOML 1.0 allows none
/// there, and toml++ 3.3 runs into undefined behaviour on some (U+029C after a number; seen by
/// fuzzing, 2026-03).
[[nodiscard]] std::optional<Finding> stray_character(std::string_view text);

}  // namespace sixdial::session
