// Text for a screen.
#pragma once

#include <string>

namespace sixdial::report {

/// Words in lines of at most 96 characters, each after `indent` (UTF-8 continuation bytes take
/// no room); ends with a newline.
[[nodiscard]] std::string wrapped(const std::string& text, const std::string& indent = "");

}  // namespace sixdial::report
