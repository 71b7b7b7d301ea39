// The codes of session/reason.h in words: brief for a place beside a figure, and a sentence.
#pragma once

#include <string>
#include <string_view>

namespace sixdial::session {

/// "no answer" of "timeout"; a code that this program does not write stays as it is.
[[nodiscard]] std::string_view brief_words(std::string_view reason);
/// "the dial does not answer in time" of "timeout".
[[nodiscard]] std::string_view reason_words(std::string_view reason);

}  // namespace sixdial::session
