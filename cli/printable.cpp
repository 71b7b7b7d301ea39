#include "cli/printable.h"

#include <fmt/format.h>

#include "session/csv.h"

namespace sixdial::cli {
namespace {

constexpr unsigned char kDelete = 0x7f;
constexpr unsigned char kFirstOfTwo = 0xc2;  // U+0080 to U+009F are C2 80 to C2 9F

bool is_control_of_two(std::string_view text, std::size_t at) {
  if (static_cast<unsigned char>(text[at]) != kFirstOfTwo || at + 1 >= text.size()) {
    return false;
  }
  const auto second = static_cast<unsigned char>(text[at + 1]);
  return second >= 0x80 && second < 0xa0;
}

/// Turns the order of what follows round (U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069):
/// a name could look like another. The code of the one at `at`; 0: none.
unsigned order_mark(std::string_view text, std::size_t at) {
  if (at + 2 >= text.size() || static_cast<unsigned char>(text[at]) != 0xe2) return 0;
  const auto second = static_cast<unsigned char>(text[at + 1]);
  const auto third = static_cast<unsigned char>(text[at + 2]);
  if (second != 0x80 && second != 0x81) return 0;
  const unsigned code = 0x2000U + (second - 0x80U) * 0x40U + (third - 0x80U);
  const bool mark = code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) ||
                    (code >= 0x2066 && code <= 0x2069);
  return mark ? code : 0;
}

}  // namespace

std::string for_terminal(std::string_view text) {
  const std::string valid = session::as_utf8(text);
  std::string safe;
  safe.reserve(valid.size());
  for (std::size_t i = 0; i < valid.size(); ++i) {
    const auto code = static_cast<unsigned char>(valid[i]);
    if (is_control_of_two(valid, i)) {
      safe += fmt::format("\\x{:02x}", static_cast<unsigned char>(valid[++i]));
    } else if (const unsigned mark = order_mark(valid, i); mark != 0) {
      safe += fmt::format("\\u{:04x}", mark);
      i += 2;
    } else if (code == '\r') {
      safe += "\\r";
    } else if ((code < 0x20 && code != '\n' && code != '\t') || code == kDelete) {
      safe += fmt::format("\\x{:02x}", code);
    } else {
      safe += valid[i];
    }
  }
  return safe;
}

std::string json_for_terminal(std::string_view line) {
  std::string safe;
  safe.reserve(line.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (is_control_of_two(line, i)) {
      safe += fmt::format("\\u00{:02x}", static_cast<unsigned char>(line[++i]));
    } else if (static_cast<unsigned char>(line[i]) == kDelete) {
      safe += "\\u007f";
    } else if (const unsigned mark = order_mark(line, i); mark != 0) {
      safe += fmt::format("\\u{:04x}", mark);
      i += 2;
    } else {
      safe += line[i];
    }
  }
  return safe;
}

}  // namespace sixdial::cli
