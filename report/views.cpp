#include "report/views.h"

#include <fmt/format.h>

#include <array>

namespace sixdial::report {
namespace {

constexpr int kInSpace = 3;
constexpr std::array<std::string_view, kInSpace> kCoordinates{"x", "y", "z"};
constexpr std::array kInThePlane{View{.across = 0, .up = 1}};
constexpr std::array kOfSpace{
    View{.across = 0, .up = 1, .from = "from above"},
    View{.across = 0, .up = 2, .from = "from the front"},
    View{.across = 1, .up = 2, .from = "from the side"}};

}  // namespace

std::span<const std::string_view> coordinates(int axes) {
  return std::span(kCoordinates).first(static_cast<std::size_t>(axes));
}

std::span<const View> views(int axes) {
  if (axes < kInSpace) return kInThePlane;
  return kOfSpace;
}

std::string titled(const std::string& title, const View& view) {
  if (view.from.empty() || title.empty()) return title + std::string(view.from);
  return fmt::format("{}, {}", title, view.from);
}

std::string views_in_words(int axes) {
  const std::span<const View> all = views(axes);
  if (all.size() == 1) return "";
  std::string words;
  for (const View& view : all) {
    const char* const joined = &view == &all.back() ? " and " : ", ";
    words += fmt::format(
        "{}{} ({}, {})", words.empty() ? "" : joined, view.from,
        coordinates(axes)[static_cast<std::size_t>(view.across)],
        coordinates(axes)[static_cast<std::size_t>(view.up)]);
  }
  return fmt::format(" Each row shows the same places {}.", words);
}

std::vector<Panel> panels_of(const ArrowMap& map) {
  std::vector<Panel> out;
  for (const View& view : views(static_cast<int>(map.axes.size()))) {
    Panel panel;
    panel.title = titled(map.title, view);
    panel.x = map.axes[static_cast<std::size_t>(view.across)];
    panel.y = map.axes[static_cast<std::size_t>(view.up)];
    panel.equal_scales = true;
    panel.arrow_scale = map.arrow_scale;
    panel.arrow_key = map.arrow_key;
    for (const Arrows& each : map.arrows) {
      Series series{.name = each.name, .mark = Mark::kArrows, .style = each.style};
      for (const geometry::Position& from : each.from_mm) {
        series.x.push_back(from[view.across]);
        series.y.push_back(from[view.up]);
      }
      for (const geometry::Position& by : each.by_mm) {
        series.dx.push_back(by[view.across]);
        series.dy.push_back(by[view.up]);
      }
      panel.series.push_back(std::move(series));
    }
    out.push_back(std::move(panel));
  }
  return out;
}

int map_panels_in_a_row(int axes, int maps) {
  const auto of_one = static_cast<int>(views(axes).size());
  return of_one > 1 ? of_one : maps;
}

}  // namespace sixdial::report
