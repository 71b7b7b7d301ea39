#include "session/toml_write.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/units.h"
#include "session/csv.h"

namespace sixdial::session {

using geometry::kRadPerDeg;

std::string toml_string(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20U || c == 0x7F) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_pair(const Eigen::Vector2d& pair) {
  return fmt::format("[{}, {}]", toml_number(pair.x()), toml_number(pair.y()));
}

double degrees_of(double rad) {
  const double near = rad / kRadPerDeg;
  for (const int digits : {6, 9, 12, 15}) {
    const double rounded = parse_number(fmt::format("{:.{}g}", near, digits)).value;
    if (rounded * kRadPerDeg == rad) return rounded;
  }
  double down = near;
  double up = near;
  for (int step = 0; step < 4; ++step) {
    if (down * kRadPerDeg == rad) return down;
    if (up * kRadPerDeg == rad) return up;
    down = std::nextafter(down, -1e300);
    up = std::nextafter(up, 1e300);
  }
  return near;
}

}  // namespace sixdial::session
