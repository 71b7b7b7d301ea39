#include "session/toml_text.h"

#include <algorithm>
#include <cctype>

namespace sixdial::session {
namespace {

bool ascii(char c) { return static_cast<unsigned char>(c) < 0x80U; }

std::size_t run_of(std::string_view text, std::size_t at, char c) {
  std::size_t count = 0;
  while (at + count < text.size() && text[at + count] == c) ++count;
  return count;
}

/// Where a backslash at `at` leads to, if that is not ASCII: an escape that TOML does not know,
/// or what follows the white space that a backslash at the end of a line takes away.
std::optional<std::size_t> not_ascii_after_backslash(
    std::string_view text, std::size_t at, bool long_string) {
  std::size_t next = at + 1;
  while (long_string && next < text.size() &&
         std::string_view(" \t\r\n").find(text[next]) != std::string_view::npos)
    ++next;
  if (next < text.size() && !ascii(text[next])) return next;
  return std::nullopt;
}

/// First place after the string that opens at `at`. A single-line string ends with its line.
/// `stray`: first character that a backslash must not lead to.
std::size_t after_string(
    std::string_view text, std::size_t at, std::optional<std::size_t>& stray) {
  const char quote = text[at];
  const bool escapes = quote == '"';
  const std::size_t opening = run_of(text, at, quote);
  if (opening == 2) return at + 2;  // empty
  const bool long_string = opening >= 3;
  std::size_t i = at + (long_string ? 3 : 1);
  while (i < text.size()) {
    if (text[i] == '\n' && !long_string) return i;
    if (text[i] == '\\' && escapes) {
      if (!stray) stray = not_ascii_after_backslash(text, i, long_string);
      i += 2;
      continue;
    }
    if (text[i] == quote) {
      const std::size_t count = run_of(text, i, quote);
      if (!long_string) return i + 1;
      if (count >= 3)
        return i + std::min<std::size_t>(count, 5);  // two may stand before the end
      i += count;
      continue;
    }
    ++i;
  }
  return text.size();
}

/// A quote inside of a word opens no string, whatever it looks like from there on.
bool opens_string(std::string_view text, std::size_t at) {
  if (text[at] != '"' && text[at] != '\'') return false;
  return at == 0 ||
         std::string_view(" \t\r\n=,[{.").find(text[at - 1]) != std::string_view::npos;
}

/// What stands before a quote in its line is a bare key and "=": anywhere else toml++ may be at
/// something else than a string by then.
bool is_value_of_key(std::string_view text, std::size_t at) {
  const std::size_t begin = text.substr(0, at).rfind('\n') + 1;  // npos + 1 is 0
  std::string_view before = text.substr(begin, at - begin);
  const auto without_blanks = [](std::string_view part) {
    const std::size_t first = part.find_first_not_of(" \t");
    if (first == std::string_view::npos) return std::string_view();
    return part.substr(first, part.find_last_not_of(" \t") - first + 1);
  };
  before = without_blanks(before);
  if (!before.ends_with('=')) return false;
  const std::string_view key = without_blanks(before.substr(0, before.size() - 1));
  return !key.empty() && std::ranges::all_of(key, [](char c) {
    return ascii(c) && (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ||
                        c == '-' || c == '.');
  });
}

Mistake finding_at(std::string_view text, std::size_t at, const char* what, const char* hint) {
  const std::string_view before = text.substr(0, at);
  const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  int column = 1;
  for (const char c : before.substr(line_start)) {
    column += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  }
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  return {static_cast<int>(line), column, "", what, hint};
}

}  // namespace

std::optional<Mistake> stray_character(std::string_view text) {
  std::size_t i = text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
  while (i < text.size()) {
    if (text[i] == '#') {
      i = std::min(text.find('\n', i), text.size());
    } else if (opens_string(text, i)) {
      std::optional<std::size_t> stray;
      const std::size_t from = i;
      i = after_string(text, i, stray);
      const std::string_view quoted = text.substr(from, std::min(i, text.size()) - from);
      const auto letter = std::ranges::find_if_not(quoted, ascii);
      if (letter != quoted.end() && !is_value_of_key(text, from)) {
        return finding_at(
            text, from + static_cast<std::size_t>(letter - quoted.begin()),
            "a character that is not ASCII stands in a string that is not the value of a key",
            "write it as an escape, \\uXXXX");
      }
      if (stray) {
        return finding_at(
            text, *stray, "a backslash in a string leads to a character that is not ASCII",
            "write the backslash twice, or use single quotes");
      }
    } else if (ascii(text[i])) {
      ++i;
    } else {
      return finding_at(
          text, i, "a character that is not ASCII stands outside quotes and comments",
          "put it in quotes or write it in ASCII");
    }
  }
  return std::nullopt;
}

}  // namespace sixdial::session
