// Places on paper. A map of places in the plane is one panel; places in space are shown as on a
// technical drawing: from above (x, y), from the front (x, z) and from the side (y, z).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/pose.h"
#include "report/document.h"

namespace sixdial::report {

/// Names of the first `axes` coordinates (2 or 3): "x", "y", "z".
[[nodiscard]] std::span<const std::string_view> coordinates(int axes);

/// Which coordinate runs to the right and which upwards. `from`: "from above"; empty where it
/// is the only view.
struct View {
  int across = 0, up = 1;
  std::string_view from{};
};
/// The views that show places of `axes` coordinates: one in the plane, three in space.
[[nodiscard]] std::span<const View> views(int axes);
/// "before", "before, from above".
[[nodiscard]] std::string titled(const std::string& title, const View& view);
/// A sentence to put behind what a map shows, with a space before it; empty in the plane.
[[nodiscard]] std::string views_in_words(int axes);

/// Arrows of one colour and name [mm]: from a place, by a vector of as many coordinates.
struct Arrows {
  std::string name{};
  int style = 0;
  std::vector<geometry::Position> from_mm{}, by_mm{};
};

/// Arrows over places, in as many coordinates as it has axes.
struct ArrowMap {
  std::string title{};
  std::vector<Axis> axes{};
  double arrow_scale = 1.0;  // of all views
  double arrow_key = 0.0;    // [mm]
  std::vector<Arrows> arrows{};
};
/// A panel for each view, with all arrows in each.
[[nodiscard]] std::vector<Panel> panels_of(const ArrowMap& map);

/// How many panels of such maps stand in a row: of places in the plane `maps`, in space the
/// views of one.
[[nodiscard]] int map_panels_in_a_row(int axes, int maps);

}  // namespace sixdial::report
