#include "acquisition/robots/linuxcnc/lines.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

namespace sixdial::acquisition {
namespace {

constexpr double kLargest = 1e9;
constexpr std::array kUnits{
    std::pair{std::string_view("MM"), 1.0},
    std::pair{std::string_view("INCH"), 25.4},
    std::pair{std::string_view("CM"), 10.0},
    std::pair{std::string_view("DEG"), 1.0},
    std::pair{std::string_view("RAD"), 180.0 / std::numbers::pi},
    std::pair{std::string_view("GRAD"), 0.9}};

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Cuts the first word off.
std::string_view take_word(std::string_view& text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  const auto* const end = std::ranges::find_if(text, is_space);
  const std::string_view word = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(word.size());
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  return word;
}

/// "ABS_ACT_POS"; what was typed comes back in small letters.
bool is_name(std::string_view word) {
  return word.size() > 1 &&
         std::ranges::all_of(word, [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; });
}

}  // namespace

std::optional<CncLine> parse_linuxcnc(std::string_view line) {
  // Older versions end some of their lines the wrong way round: \n\r.
  while (!line.empty() && is_space(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
  const bool text = std::ranges::none_of(line, [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return (code < 0x20 && c != '\t') || code == 0x7f;
  });
  if (!text) return std::nullopt;
  if (line.starts_with("error: ")) {
    return CncLine{.kind = CncLineKind::kError, .rest = std::string(line.substr(7))};
  }
  std::string_view rest = line;
  const std::string_view first = take_word(rest);
  if (first == "HELLO" && (rest == "NAK" || rest.starts_with("ACK"))) {
    return CncLine{
        .kind = rest == "NAK" ? CncLineKind::kNak : CncLineKind::kAck,
        .name = "HELLO",
        .rest = std::string(rest)};
  }
  if (first == "SET" || first == "GET") {
    if (rest == "NAK") return CncLine{.kind = CncLineKind::kNak};
    const std::string_view name = take_word(rest);
    if (is_name(name) && (rest == "NAK" || (rest == "ACK" && first == "SET"))) {
      return CncLine{
          .kind = rest == "NAK" ? CncLineKind::kNak : CncLineKind::kAck,
          .name = std::string(name)};
    }
    return CncLine{};
  }
  if (!is_name(first)) return CncLine{};
  return CncLine{
      .kind = CncLineKind::kValue, .name = std::string(first), .rest = std::string(rest)};
}

std::optional<std::vector<double>> cnc_figures(std::string_view text) {
  std::vector<double> figures;
  while (!text.empty()) {
    const std::string_view word = take_word(text);
    if (word.empty()) break;
    double figure = 0.0;
    const auto [end, error] = std::from_chars(
        word.data(), word.data() + word.size(), figure, std::chars_format::fixed);
    if (error != std::errc{} || end != word.data() + word.size() ||
        !(std::abs(figure) < kLargest)) {
      return std::nullopt;
    }
    figures.push_back(figure);
  }
  return figures;
}

std::vector<std::string> cnc_words(std::string_view text) {
  std::vector<std::string> words;
  for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) {
    words.emplace_back(word);
  }
  return words;
}

std::optional<double> cnc_unit(std::string_view name) {
  const auto* const found =
      std::ranges::find_if(kUnits, [name](const auto& unit) { return unit.first == name; });
  return found == kUnits.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace sixdial::acquisition
