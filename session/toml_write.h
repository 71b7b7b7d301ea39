// Values as a rig file writes them.
#pragma once

#include <Eigen/Core>
#include <string>

namespace sixdial::session {

/// Quoted, with escapes.
[[nodiscard]] std::string toml_string(const std::string& text);
/// Shortest text that reads back as the same double, always with a point or an exponent.
[[nodiscard]] std::string toml_number(double value);
[[nodiscard]] std::string toml_pair(const Eigen::Vector2d& pair);
/// Degrees that convert back to the same radians, if a double does; the shortest such number.
[[nodiscard]] double degrees_of(double rad);

}  // namespace sixdial::session
