// A long text in pieces that fit into a line of the socket.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace sixdial::service {

/// Doubled by quotes in the worst case.
inline constexpr std::size_t kMostPageBytes = std::size_t{24} * 1024;

/// Where the page that begins at `begin` ends: not in the middle of a UTF-8 letter.
[[nodiscard]] inline std::size_t page_end(const std::string& text, std::size_t begin) {
  std::size_t end = std::min(text.size(), begin + kMostPageBytes);
  while (end < text.size() && end > begin && (text[end] & 0xC0) == 0x80) --end;
  return end;
}

}  // namespace sixdial::service
