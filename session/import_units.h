// Units as files write them: in a map, in a row beneath the header, in a column's name.
//
//   find_import_unit("°")->in_stored;   // 0.01745...: radians of one degree
//   unit_in_name("px [mm]").unit->name;  // "mm"; its `base` is "px"
#pragma once

#include <string>
#include <string_view>

namespace sixdial::session {

enum class UnitKind {
  kLength,
  kAngle,
  kTemperature,
  kOther,  // known as a unit, of nothing that a session holds
  kNone,   // no unit at all: of a quaternion
};

struct ImportUnit {
  std::string_view name;  // as a map writes it
  UnitKind kind = UnitKind::kOther;
  double in_stored = 1.0;  // one of it, in mm, rad or degC
  double offset = 0.0;     // added then: 0 K are -273.15 degC
};

/// By any of its spellings, in whatever case ("Degrees", "°"); null: it is none.
[[nodiscard]] const ImportUnit* find_import_unit(std::string_view text);

/// Of a map's `unit`: the units of lengths and angles, in words.
inline constexpr std::string_view kMapUnits =
    "mm, m, cm, um, in for a length, rad, mrad, deg, gon for an angle";

/// "grad" is the degree in German, a hundredth of a right angle elsewhere.
[[nodiscard]] bool is_doubtful_unit(std::string_view text);

struct NameWithUnit {
  std::string base;                  // the name without it
  std::string text;                  // the unit as it stands there
  const ImportUnit* unit = nullptr;  // null: the name says none
  /// In brackets or behind a '/': it can be nothing else. An ending may: "x_m" is x in metres,
  /// or x as it was measured.
  bool certain = false;
  /// What stands in brackets and is no unit that is known, or an ending that may be one, or a
  /// word: "[ft]", "_in". With a `unit` it is empty.
  std::string unknown{};
};
[[nodiscard]] NameWithUnit unit_in_name(std::string_view name);

/// In lower case; bytes beyond ASCII stay as they are.
[[nodiscard]] std::string in_lower_case(std::string_view text);

}  // namespace sixdial::session
