#include "acquisition/robots/gcode/dialect.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace sixdial::acquisition {

extern const GcodeDialect grbl;
extern const GcodeDialect marlin;
extern const GcodeDialect klipper;

namespace {

constexpr std::array kDialects{&grbl, &marlin, &klipper};
constexpr double kLargest = 1e9;

}  // namespace

std::span<const GcodeDialect* const> gcode_dialects() { return kDialects; }

const GcodeDialect* find_gcode_dialect(std::string_view name) {
  const auto* const found = std::ranges::find(kDialects, name, &GcodeDialect::name);
  return found == kDialects.end() ? nullptr : *found;
}

std::optional<AxisFigure> axis_figure(char letter, std::string_view text) {
  AxisFigure figure{.letter = letter};
  const auto [end, error] = std::from_chars(
      text.data(), text.data() + text.size(), figure.value, std::chars_format::fixed);
  if (error != std::errc{} || end != text.data() + text.size() ||
      !(std::abs(figure.value) < kLargest)) {
    return std::nullopt;
  }
  if (const std::size_t point = text.find('.'); point != std::string_view::npos) {
    figure.decimals = static_cast<int>(text.size() - point - 1);
  }
  return figure;
}

std::optional<std::vector<AxisFigure>> lettered_axes(std::string_view text) {
  std::vector<AxisFigure> axes;
  while (!text.empty()) {
    const std::size_t blank = text.find(' ');
    const std::string_view word = text.substr(0, blank);
    text = blank == std::string_view::npos ? std::string_view() : text.substr(blank + 1);
    if (word == "Count") break;
    if (word.empty()) continue;
    if (word.size() < 3 || word[0] < 'A' || word[0] > 'Z' || word[1] != ':') {
      return std::nullopt;
    }
    const auto figure = axis_figure(word[0], word.substr(2));
    if (!figure || std::ranges::find(axes, word[0], &AxisFigure::letter) != axes.end()) {
      return std::nullopt;
    }
    axes.push_back(*figure);
  }
  if (axes.empty()) return std::nullopt;
  return axes;
}

bool is_text(std::string_view line) {
  return std::ranges::none_of(line, [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return (code < 0x20 && c != '\t') || code == 0x7f;
  });
}

}  // namespace sixdial::acquisition
