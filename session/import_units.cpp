#include "session/import_units.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "geometry/units.h"

namespace sixdial::session {
namespace {

constexpr double kRadPerGon = geometry::kRadPerDeg * 0.9;
constexpr double kKelvinAtZero_degC = 273.15;
constexpr double kDegCPerDegF = 5.0 / 9.0;

constexpr std::array kUnits{
    ImportUnit{"mm", UnitKind::kLength, 1.0},
    ImportUnit{"m", UnitKind::kLength, 1000.0},
    ImportUnit{"cm", UnitKind::kLength, 10.0},
    ImportUnit{"um", UnitKind::kLength, 1e-3},
    ImportUnit{"in", UnitKind::kLength, 25.4},
    ImportUnit{"rad", UnitKind::kAngle, 1.0},
    ImportUnit{"mrad", UnitKind::kAngle, 1e-3},
    ImportUnit{"deg", UnitKind::kAngle, geometry::kRadPerDeg},
    ImportUnit{"gon", UnitKind::kAngle, kRadPerGon},
    ImportUnit{"degC", UnitKind::kTemperature, 1.0},
    ImportUnit{"K", UnitKind::kTemperature, 1.0, -kKelvinAtZero_degC},
    ImportUnit{"degF", UnitKind::kTemperature, kDegCPerDegF, -32.0 * kDegCPerDegF},
    ImportUnit{"other"}};

struct Spelling {
  std::string_view text;  // in lower case
  std::string_view name;  // of the unit
};
constexpr std::array kSpellings{
    Spelling{"millimeter", "mm"},   Spelling{"millimeters", "mm"}, Spelling{"millimetre", "mm"},
    Spelling{"millimetres", "mm"},  Spelling{"meter", "m"},        Spelling{"meters", "m"},
    Spelling{"metre", "m"},         Spelling{"metres", "m"},       Spelling{"centimeter", "cm"},
    Spelling{"centimetre", "cm"},   Spelling{"\u00B5m", "um"},     Spelling{"\u03BCm", "um"},
    Spelling{"micron", "um"},       Spelling{"microns", "um"},     Spelling{"micrometer", "um"},
    Spelling{"micrometre", "um"},   Spelling{"inch", "in"},        Spelling{"inches", "in"},
    Spelling{"zoll", "in"},         Spelling{"radian", "rad"},     Spelling{"radians", "rad"},
    Spelling{"degree", "deg"},      Spelling{"degrees", "deg"},    Spelling{"\u00B0", "deg"},
    Spelling{"\u00BA", "deg"},      Spelling{"celsius", "degC"},   Spelling{"\u00B0c", "degC"},
    Spelling{"c", "degC"},          Spelling{"kelvin", "K"},       Spelling{"\u00B0f", "degF"},
    Spelling{"fahrenheit", "degF"}, Spelling{"f", "degF"}};

/// Units of what a session does not hold: a row of units has them beside the others.
constexpr auto kOthers = std::to_array<std::string_view>(
    {"-",    "1",   "s",     "sec",   "ms",       "us",    "min", "h",      "hz",  "n",  "nm",
     "kn",   "v",   "mv",    "a",     "ma",       "%",     "kg",  "g",      "bar", "pa", "hpa",
     "mm/s", "m/s", "deg/s", "rad/s", "\u00B0/s", "steps", "inc", "counts", "grad"});

/// Endings of a name that are taken for a unit.
constexpr auto kEndings = std::to_array<std::string_view>(
    {"mm", "m", "cm", "um", "\u00B5m", "\u03BCm", "inch", "inches", "rad", "mrad", "deg",
     "degrees", "radians", "gon", "degc"});

/// Endings that may be a unit, or a word or a letter: told, not taken.
constexpr auto kDoubtfulEndings = std::to_array<std::string_view>(
    {"in", "ft",     "feet",  "mil",    "mils",  "thou", "dm",    "arcmin", "arcsec", "f",
     "k",  "counts", "ticks", "pulses", "steps", "inc",  "turns", "revs",   "nm",     "grad"});

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string_view without_brackets(std::string_view text) {
  text = trimmed(text);
  for (const std::string_view pair : {"[]", "()", "{}", "<>"}) {
    if (text.size() > 2 && text.front() == pair[0] && text.back() == pair[1]) {
      return trimmed(text.substr(1, text.size() - 2));
    }
  }
  return text;
}

/// Begin of the bracket that the name ends with; npos: it ends with none.
std::size_t last_bracket(std::string_view name) {
  for (const std::string_view pair : {"[]", "()", "{}", "<>"}) {
    if (!name.empty() && name.back() == pair[1]) return name.rfind(pair[0]);
  }
  return name.npos;
}

/// "q[1]", "axis/1" are no numbers without a unit.
bool is_index(std::string_view text) { return text == "1" || text == "-"; }

}  // namespace

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  for (char& letter : lower) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte < 0x80U) letter = static_cast<char>(std::tolower(byte));
  }
  return lower;
}

bool is_doubtful_unit(std::string_view text) {
  return in_lower_case(without_brackets(text)) == "grad";
}

const ImportUnit* find_import_unit(std::string_view text) {
  const std::string lower = in_lower_case(without_brackets(text));
  if (lower.empty()) return nullptr;
  std::string_view name = lower;
  if (const auto* const spelt = std::ranges::find(kSpellings, name, &Spelling::text);
      spelt != kSpellings.end()) {
    name = spelt->name;
  } else if (std::ranges::find(kOthers, name) != kOthers.end()) {
    return &kUnits.back();
  }
  for (const ImportUnit& unit : kUnits) {
    if (&unit != &kUnits.back() && in_lower_case(unit.name) == in_lower_case(name)) {
      return &unit;
    }
  }
  return nullptr;
}

NameWithUnit unit_in_name(std::string_view whole) {
  const std::string_view name = trimmed(whole);
  const auto found = [&](std::size_t end_of_base, std::string_view text, bool certain) {
    return NameWithUnit{
        std::string(trimmed(name.substr(0, end_of_base))), std::string(without_brackets(text)),
        is_index(without_brackets(text)) ? nullptr : find_import_unit(text), certain};
  };

  const std::size_t bracket = last_bracket(name);
  if (bracket != name.npos && bracket > 0) {
    const NameWithUnit split = found(bracket, name.substr(bracket), true);
    if (split.unit != nullptr && !split.base.empty()) return split;
    return {std::string(name), "", nullptr, false, split.text};
  }
  const std::size_t at = name.find_last_of("_ /,.");
  if (at == name.npos || at == 0 || at + 1 >= name.size()) {
    return {std::string(name), "", nullptr, false};
  }
  const std::string_view ending = name.substr(at + 1);
  if (name[at] == '/') {
    const NameWithUnit split = found(at, ending, true);
    if (split.unit != nullptr && !split.base.empty()) return split;
  } else if (std::ranges::find(kEndings, in_lower_case(ending)) != kEndings.end()) {
    NameWithUnit split = found(at, ending, false);
    if (in_lower_case(split.base).ends_with(" in")) {  // "J1 in deg"
      split.base =
          std::string(trimmed(std::string_view(split.base).substr(0, split.base.size() - 3)));
      split.certain = true;
    }
    if (!split.base.empty()) return split;
  }
  if (std::ranges::find(kDoubtfulEndings, in_lower_case(ending)) != kDoubtfulEndings.end()) {
    return {std::string(name), "", nullptr, false, std::string(ending)};
  }
  return {std::string(name), "", nullptr, false};
}

}  // namespace sixdial::session
