// Numbers of a dial that a rig file gives for all dials or for one; read and written by the
// same list.
#pragma once

#include <array>
#include <string_view>

#include "geometry/rig.h"

namespace sixdial::session {

// Figures that [dials] gives for all and a [[dial]] may override.
struct DialFigure {
  const char* key;
  double& (*of)(geometry::Dial& dial);
  bool required;
  bool zero_allowed;
};
/// Of dials on a cuboid only.
inline constexpr std::string_view kTipRadius = "tip_radius_mm";
inline constexpr std::array<DialFigure, 7> kDialFigures{{
    {"travel_mm", [](geometry::Dial& d) -> double& { return d.geometry.travel_mm; }, true,
     false},
    {"resolution_mm", [](geometry::Dial& d) -> double& { return d.resolution_mm; }, true,
     false},
    {"accuracy_mm", [](geometry::Dial& d) -> double& { return d.accuracy_mm; }, false, true},
    {"repeatability_mm", [](geometry::Dial& d) -> double& { return d.repeatability_mm; }, true,
     true},
    {"tip_radius_mm", [](geometry::Dial& d) -> double& { return d.geometry.tip_radius_mm; },
     true, true},
    {"force_n", [](geometry::Dial& d) -> double& { return d.force_n; }, false, true},
    {"spring_n_per_mm", [](geometry::Dial& d) -> double& { return d.spring_n_per_mm; }, false,
     true},
}};

}  // namespace sixdial::session
