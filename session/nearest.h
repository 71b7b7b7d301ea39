// "unknown parameter 'sesion'; the nearest known one is 'session'": the nearest known name to a
// mistyped one, by edit distance.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace sixdial::session {

/// Number of letters to insert, delete or replace.
[[nodiscard]] int edit_distance(std::string_view a, std::string_view b);
/// Empty beyond half the letters of the longer word, and for a word of more than 64.
[[nodiscard]] std::optional<std::string_view> nearest_name(
    std::string_view word, std::span<const std::string_view> known);

}  // namespace sixdial::session
