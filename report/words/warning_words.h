// What plausibility found, in words: one row a code, the sentence with its parts in braces.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "studies/plausibility.h"

namespace sixdial::report {

/// What is the matter and what to do, in one or two sentences.
[[nodiscard]] std::string warning_text(const studies::Warning& warning);
/// "session.csv, lines 3, 5 and 9, column dial_A_mm"; of samples without a line "G1 point 4".
[[nodiscard]] std::string where_text(const studies::WarningPlace& place);
/// Both: what people read at the top of a command and of a report.
[[nodiscard]] std::string warning_line(const studies::Warning& warning);
[[nodiscard]] std::vector<std::string> warning_lines(
    const std::vector<studies::Warning>& warnings);
/// One below the other with "! " before each, broken into lines; empty for none.
[[nodiscard]] std::string warnings_text(const std::vector<studies::Warning>& warnings);
/// "note", "doubt", "wrong".
[[nodiscard]] std::string_view severity_name(studies::Severity severity);

/// Whether a code has words: a test holds it against studies' table of checks.
[[nodiscard]] bool has_words(std::string_view code);

}  // namespace sixdial::report
