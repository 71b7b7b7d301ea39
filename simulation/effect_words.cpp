#include "simulation/effect_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/coverage.h"
#include "geometry/units.h"

namespace sixdial::simulation {
namespace {

/// A value in the unit that people read, and that unit.
struct Shown {
  double factor;
  std::string unit;  // with a space before it where one belongs
};
Shown as_read(std::string_view unit) {
  if (unit == "rad") return {geometry::kDegPerRad, "\u00B0"};
  if (unit == "1/K") return {1e6, " \u00B5m/(m\u00B7K)"};
  if (unit == "rad/(N mm)") return {1e6, " \u00B5rad/(N\u00B7mm)"};
  if (unit == "1") return {100.0, " %"};
  return {1.0, unit.empty() ? std::string() : fmt::format(" {}", unit)};
}

int decimals_of(double resolved) {
  if (!(resolved > 0.0) || !std::isfinite(resolved)) return 4;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(resolved))), 0, 7);
}

/// "a,b" -> the length of the vector of those that are there; empty if none is.
std::string together(std::string_view names, std::span<const FoundParameter> found) {
  std::vector<FoundParameter> parts;
  while (!names.empty()) {
    const std::string_view name = names.substr(0, names.find(','));
    names.remove_prefix(std::min(names.size(), name.size() + 1));
    const auto each = std::ranges::find(found, name, &FoundParameter::name);
    if (each != found.end()) parts.push_back(*each);
  }
  if (parts.empty()) return "";
  if (parts.size() == 1) {  // with its sign
    return quantity_in_words(parts[0].value, parts[0].sd, parts[0].unit);
  }
  double square = 0.0;
  double variance = 0.0;
  for (const FoundParameter& each : parts) {
    square += each.value * each.value;
    variance += std::pow(each.value * each.sd, 2);
  }
  const double size = std::sqrt(square);
  const double sd = size > 0.0 ? std::sqrt(variance) / size : parts[0].sd;
  return quantity_in_words(size, sd, parts[0].unit);
}

/// "a" or "a:.2f" -> its value alone, with three digits or so many decimals; a whole number
/// that has no unit as it is.
std::string bare(std::string_view text, std::span<const FoundParameter> found) {
  const std::string_view name = text.substr(0, text.find(':'));
  const auto each = std::ranges::find(found, name, &FoundParameter::name);
  if (each == found.end()) return "";
  if (each->unit == "1") return fmt::format("{:.0f}", each->value);
  const Shown shown = as_read(each->unit);
  if (text.size() == name.size()) return in_digits(each->value * shown.factor, 3) + shown.unit;
  const std::string_view digits = text.substr(name.size());
  return fmt::format(
      fmt::runtime(fmt::format("{{{}}}{{}}", digits)), each->value * shown.factor, shown.unit);
}

}  // namespace

std::string in_digits(double value, int digits) {
  constexpr double kLeast = 1e-9;  // below, and from kMost on, an exponent is easier to read
  constexpr double kMost = 1e12;
  const std::string rounded = fmt::format("{:.{}e}", value, digits - 1);
  const std::size_t at = rounded.find('e');
  const double size = std::abs(value);
  if (at == std::string::npos || size < kLeast || size >= kMost) {
    return fmt::format("{:.{}g}", value, digits);
  }
  const int power = std::stoi(rounded.substr(at + 1));
  // The rounded number in full: "4.45e+04" is 44500.
  std::string text =
      fmt::format("{:.{}f}", std::stod(rounded), std::max(0, digits - 1 - power));
  if (text.find('.') != std::string::npos) {  // as {:g} has it, no zeros at the end
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text;
}

std::string quantity_in_words(double value, double sd, std::string_view unit) {
  const Shown shown = as_read(unit);
  const double size = value * shown.factor;
  const double uncertain = sd * shown.factor;
  if (!std::isfinite(uncertain) || !(uncertain > 0.0)) {
    return in_digits(size, 3) + shown.unit;
  }
  const double expanded = geometry::kCoverage * uncertain;
  const int decimals = decimals_of(expanded);
  return fmt::format(
      "{:.{}f}{} \u00B1 {:.{}f}{}", size, decimals, shown.unit, expanded, decimals, shown.unit);
}

namespace {

/// A template with its values; `complete` becomes false where one of them is missing.
std::string filled(
    std::string_view rest, std::span<const FoundParameter> found, bool& complete) {
  std::string words;
  while (!rest.empty()) {
    const std::size_t open = std::min(rest.find_first_of("{["), rest.size());
    words += rest.substr(0, open);
    rest.remove_prefix(open);
    if (rest.empty()) break;
    const bool part = rest.front() == '[';
    const std::size_t close = std::min(rest.find(part ? ']' : '}'), rest.size() - 1);
    const std::string_view inside = rest.substr(1, close - 1);
    rest.remove_prefix(close + 1);
    if (part) {
      bool whole = true;
      const std::string own = filled(inside, found, whole);
      if (whole) words += own;
      continue;
    }
    const std::string value =
        inside.starts_with('=') ? bare(inside.substr(1), found) : together(inside, found);
    complete = complete && !value.empty();
    words += value;
  }
  return words;
}

std::string size_without_k(const Effect& effect, std::span<const FoundParameter> found) {
  std::string words;
  if (effect.size.empty()) {
    for (const FoundParameter& each : found) {
      if (!words.empty()) words += ", ";
      if (found.size() > 1) words += fmt::format("{} ", each.name);
      words += quantity_in_words(each.value, each.sd, each.unit);
    }
    return words;
  }
  bool complete = true;
  return filled(effect.size, found, complete);
}

}  // namespace

std::string size_in_words(const Effect& effect, std::span<const FoundParameter> found) {
  std::string words = size_without_k(effect, found);
  const auto is_uncertain = [](const FoundParameter& each) { return each.sd > 0.0; };
  if (std::ranges::any_of(found, is_uncertain)) {
    words += fmt::format(" (k = {:.0f})", geometry::kCoverage);
  }
  return words;
}

}  // namespace sixdial::simulation
