#include "report/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sixdial::report {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD
constexpr std::string_view kDash = "\xE2\x80\x93";         // U+2013

/// Length of the valid UTF-8 sequence that `text` begins with; 0 if it is none (RFC 3629).
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const auto continues = [&](std::size_t i, unsigned low = 0x80, unsigned high = 0xBF) {
    return i < text.size() && byte(i) >= low && byte(i) <= high;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return continues(1) ? 2 : 0;
  if (first >= 0xE0 && first <= 0xEF) {
    const unsigned low = first == 0xE0 ? 0xA0 : 0x80;   // no overlong form
    const unsigned high = first == 0xED ? 0x9F : 0xBF;  // no surrogate
    return continues(1, low, high) && continues(2) ? 3 : 0;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    const unsigned low = first == 0xF0 ? 0x90 : 0x80;
    const unsigned high = first == 0xF4 ? 0x8F : 0xBF;  // up to U+10FFFF
    return continues(1, low, high) && continues(2) && continues(3) ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string valid_utf8(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t n = sequence_length(text);
    const auto first = static_cast<unsigned char>(text.front());
    const bool control = first < 0x20 ? first != '\t' && first != '\n' : first == 0x7F;
    const bool c1_control =
        n == 2 && first == 0xC2 && static_cast<unsigned char>(text[1]) < 0xA0;
    if (n == 0 || control || c1_control) {
      out += kReplacement;
    } else {
      out += text.substr(0, n);
    }
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return out;
}

std::string escape_html(std::string_view text) {
  std::string out;
  for (const char c : valid_utf8(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string escape_script(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    switch (c) {
      case '<':
        out += "\\u003c";
        break;
      case '>':
        out += "\\u003e";
        break;
      case '&':
        out += "\\u0026";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string csv_field(std::string_view text) {
  const std::string clean = valid_utf8(text);
  if (clean.find_first_of(",\"\n") == std::string::npos) return clean;
  std::string out = "\"";
  for (const char c : clean) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return std::string{kDash};
  std::string out = fmt::format("{:.{}f}", value, decimals);
  if (out.front() == '-' && out.find_first_of("123456789") == std::string::npos)
    out.erase(0, 1);
  return out;
}

std::string exact(double value) {
  if (!std::isfinite(value)) return {};
  return fmt::format("{}", value == 0.0 ? 0.0 : value);
}

std::string shown(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* n = std::get_if<Number>(&cell))
    return fixed(n->value * n->shown_times, n->decimals);
  return std::string{kDash};
}

int decimals_for(double standard_deviation) {
  if (!std::isfinite(standard_deviation) || standard_deviation <= 0.0) return 4;
  // Rounding to two digits can carry into a third: 0.0999 is shown as 0.100.
  const double rounded = std::stod(fmt::format("{:.1e}", standard_deviation));
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(rounded))), 1, 7);
}

std::string length(double value_mm) {
  if (!std::isfinite(value_mm)) return std::string{kDash};
  const double size_mm = std::abs(value_mm);
  if (size_mm == 0.0) return "0 mm";
  const bool small = size_mm < 0.0999;
  const double value = small ? value_mm * 1000.0 : value_mm;
  const int before_point = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  const int wanted = (small && std::abs(value) < 10.0) ? 2 : 3;  // no digits of a nanometre
  return fmt::format(
      "{}\u00A0{}", fixed(value, std::clamp(wanted - before_point, 0, 2)),
      small ? "\u00B5m" : "mm");
}

std::string counted(long long n, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

std::string readable_time(std::string_view iso8601) {
  if (iso8601.size() < 17 || iso8601[10] != 'T' || iso8601.back() != 'Z') {
    return std::string{iso8601};
  }
  return fmt::format("{} {} UTC", iso8601.substr(0, 10), iso8601.substr(11, 5));
}

}  // namespace sixdial::report
