// Text of files, devices and other programs as a terminal may get it.
#pragma once

#include <string>
#include <string_view>

namespace sixdial::cli {

/// Control characters spelt out ("\x1b", "\r", also those of two bytes in UTF-8), and what is
/// no UTF-8 as '?'; newlines and tabs stay. A file's bytes then neither move the cursor nor
/// colour, retitle or answer for the terminal.
[[nodiscard]] std::string for_terminal(std::string_view text);
/// A line of JSON, where control characters beyond those of ASCII become \u escapes, too.
[[nodiscard]] std::string json_for_terminal(std::string_view line);

}  // namespace sixdial::cli
