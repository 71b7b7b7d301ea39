// Rows of a kind's list of parameters, for kinds of robot in space.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "geometry/parameter.h"
#include "geometry/units.h"

namespace sixdial::geometry {

/// A length, or an angle, a turn of which moves the tool by `lever_mm`. `rig_key` empty: not in
/// the file under a key of its own.
[[nodiscard]] inline ParameterInfo parameter_row(
    const std::string& name, bool angle, double lever_mm, const std::string& meaning,
    std::string rig_key = {}) {
  ParameterInfo info;
  info.name = name;
  info.rig_key = std::move(rig_key);
  info.shown_unit = angle ? "deg" : "mm";
  info.shown_per_unit = angle ? kDegPerRad : 1.0;
  info.unit = angle ? "rad" : "mm";
  info.change = angle ? 1.0 / lever_mm : 1.0;
  info.optional = true;
  info.meaning = meaning;
  info.plainly = meaning;
  return info;
}
[[nodiscard]] inline ParameterInfo length_row(
    const std::string& name, const std::string& meaning) {
  return parameter_row(name, false, 1.0, meaning, name + "_mm");
}
[[nodiscard]] inline ParameterInfo angle_row(
    const std::string& name, double lever_mm, const std::string& meaning) {
  return parameter_row(name, true, lever_mm, meaning, name + "_deg");
}

/// Six rows: where a frame is (x, y, z), and its rotation vector.
inline void add_frame_rows(
    std::vector<ParameterInfo>& rows, const std::string& frame, double lever_mm,
    const std::string& meaning) {
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  const std::size_t first = rows.size();
  for (const char* const axis : kAxes) {
    rows.push_back(length_row(frame + '_' + axis, meaning + ", along " + axis));
  }
  for (const char* const axis : kAxes) {
    rows.push_back(
        angle_row(frame + "_r" + axis, lever_mm, meaning + ", turned about " + axis));
  }
  for (std::size_t k = first; k < rows.size(); ++k) rows[k].stands = true;
}

}  // namespace sixdial::geometry
