// What must be looked at in TOML text before toml++ may see it.
#pragma once

#include <optional>
#include <string_view>

#include "session/data_error.h"

namespace sixdial::session {

/// The first character that is not ASCII outside quotes and comments, or to which a backslash
/// in a string leads. TOML 1.0 allows none there, but for what follows a line that a backslash
/// ends, and toml++ 3.3 runs into undefined behaviour on some (U+029C after a number, U+FEFE
/// after a backslash; seen by fuzzing).
[[nodiscard]] std::optional<Mistake> stray_character(std::string_view text);

}  // namespace sixdial::session
