// The words of each warning that the check of a session, or a fit, may have.
#pragma once

#include <span>
#include <string_view>

namespace sixdial::report {

/// `text`: {name} is a part of the warning, {rows} how many rows it names, {rows:row|rows} that
/// number with its noun, {rows|is|are} the word alone; {name:.3f} a figure so. What stands in [
/// ] is left out where one of its parts is not there.
struct WarningWords {
  std::string_view code;
  std::string_view text;
};

/// One for each code of studies::Warning.
[[nodiscard]] std::span<const WarningWords> warning_table();

}  // namespace sixdial::report
