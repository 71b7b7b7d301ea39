// Decimal numbers as dials print them: digits, one point, digits. No exponent, no "nan".
#pragma once

#include <charconv>
#include <string_view>
#include <tl/expected.hpp>

#include "acquisition/dial_protocol.h"

namespace sixdial::acquisition {

/// All of `text`, "012.345", and how many decimals it has. The sign is the caller's: '-' or
/// not.
[[nodiscard]] inline tl::expected<DialFrame, FaultKind> parse_decimal(
    std::string_view text, char sign, Unit unit) noexcept {
  const auto bad = tl::unexpected(FaultKind::kBadFrame);
  const std::size_t point = text.find('.');
  if (text.size() > 12 || point == 0 || point == std::string_view::npos ||
      point + 1 >= text.size()) {
    return bad;
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i != point && (text[i] < '0' || text[i] > '9')) return bad;
  }
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (error != std::errc{} || end != text.data() + text.size()) return bad;
  return DialFrame{
      .value = sign == '-' ? -value : value,
      .unit = unit,
      .decimals = static_cast<int>(text.size() - point - 1)};
}

}  // namespace sixdial::acquisition
