// How print spells the name of a parameter or a joint.
#include <algorithm>
#include <array>

#include "report/tables.h"

namespace sixdial::report {
namespace {

struct Letter {
  std::string_view name, symbol;
};
constexpr std::array<Letter, 8> kGreek{{
    {"alpha", "\u03B1"},
    {"beta", "\u03B2"},
    {"gamma", "\u03B3"},
    {"delta", "\u03B4"},
    {"theta", "\u03B8"},
    {"phi", "\u03C6"},
    {"psi", "\u03C8"},
    {"omega", "\u03C9"},
}};

/// "\u03B8" for "theta", the letter itself for one letter; empty: no letter.
std::string letter_of(std::string_view stem) {
  const auto* const greek = std::ranges::find(kGreek, stem, &Letter::name);
  if (greek != kGreek.end()) return std::string(greek->symbol);
  return stem.size() == 1 ? std::string(stem) : std::string();
}

}  // namespace

std::string symbol(std::string_view name) {
  if (name == "clamp") return "\u03B3\u2080";  // spec 1 has no letter of its own for it
  const auto digits = name.find_first_of("0123456789");
  const std::string_view stem = name.substr(0, digits);
  std::string text = letter_of(stem);
  if (text.empty() && stem.starts_with('d') && !letter_of(stem.substr(1)).empty()) {
    text = "\u03B4" + letter_of(stem.substr(1));
  }
  if (text.empty()) return std::string(name);
  for (const char digit : name.substr(stem.size())) {
    if (digit < '0' || digit > '9') return std::string(name);
    text += "\xE2\x82";  // U+2080 and on: subscripts
    text += static_cast<char>(0x80 + (digit - '0'));
  }
  return text;
}

}  // namespace sixdial::report
