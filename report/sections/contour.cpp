#include "report/sections/contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sixdial::report {
namespace {

/// A grid edge: from corner (column, row) to the right (0) or up (1). Lines meet in them.
struct Edge {
  int column, row, direction;
  auto operator<=>(const Edge&) const = default;
};
using Segment = std::pair<Edge, Edge>;

class Grid {
 public:
  Grid(
      std::span<const double> x, std::span<const double> y, std::span<const double> values,
      double level)
      : x_(x), y_(y), values_(values), level_(level) {}

  [[nodiscard]] double above(int column, int row) const {
    return values_
               [static_cast<std::size_t>(row) * x_.size() + static_cast<std::size_t>(column)] -
           level_;
  }
  [[nodiscard]] Eigen::Vector2d corner(int column, int row) const {
    return {x_[static_cast<std::size_t>(column)], y_[static_cast<std::size_t>(row)]};
  }
  [[nodiscard]] Eigen::Vector2d crossing(const Edge& edge) const {
    const int column = edge.column + (edge.direction == 0 ? 1 : 0);
    const int row = edge.row + (edge.direction == 1 ? 1 : 0);
    const double from = above(edge.column, edge.row);
    const double to = above(column, row);
    const double part = from / (from - to);
    return (1.0 - part) * corner(edge.column, edge.row) + part * corner(column, row);
  }
  /// The lines through one cell: none, one, or two at a saddle.
  [[nodiscard]] std::vector<Segment> segments(int column, int row) const {
    const std::array<double, 4> corners{
        above(column, row), above(column + 1, row), above(column + 1, row + 1),
        above(column, row + 1)};
    for (const double value : corners) {
      if (!std::isfinite(value)) return {};
    }
    // Sides in turn: below, right, above, left.
    const std::array<Edge, 4> sides{
        Edge{column, row, 0}, Edge{column + 1, row, 1}, Edge{column, row + 1, 0},
        Edge{column, row, 1}};
    std::vector<Edge> crossed;
    for (std::size_t k = 0; k < 4; ++k) {
      if ((corners[k] < 0.0) != (corners[(k + 1) % 4] < 0.0)) crossed.push_back(sides[k]);
    }
    if (crossed.size() == 2) return {{crossed[0], crossed[1]}};
    if (crossed.size() != 4) return {};
    const double centre = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0;
    const bool apart = (centre < 0.0) == (corners[0] < 0.0);
    return apart ? std::vector<Segment>{{crossed[0], crossed[1]}, {crossed[2], crossed[3]}}
                 : std::vector<Segment>{{crossed[3], crossed[0]}, {crossed[1], crossed[2]}};
  }

 private:
  std::span<const double> x_, y_, values_;
  double level_;
};

/// Takes the segment that begins or ends at `at` and gives its other end.
bool take_next(std::vector<Segment>& left, Edge& at) {
  const auto next = std::ranges::find_if(
      left, [&](const Segment& each) { return each.first == at || each.second == at; });
  if (next == left.end()) return false;
  at = next->first == at ? next->second : next->first;
  left.erase(next);
  return true;
}

}  // namespace

std::vector<Polyline> contour_lines(
    std::span<const double> x, std::span<const double> y, std::span<const double> values,
    double level) {
  const Grid grid(x, y, values, level);
  std::vector<Segment> left;
  for (int row = 0; row + 1 < static_cast<int>(y.size()); ++row) {
    for (int column = 0; column + 1 < static_cast<int>(x.size()); ++column) {
      const auto here = grid.segments(column, row);
      left.insert(left.end(), here.begin(), here.end());
    }
  }
  std::vector<Polyline> lines;
  while (!left.empty()) {
    const Segment first = left.back();
    left.pop_back();
    Polyline line{grid.crossing(first.first), grid.crossing(first.second)};
    Edge at = first.second;
    while (take_next(left, at)) line.push_back(grid.crossing(at));
    at = first.first;
    while (take_next(left, at)) line.insert(line.begin(), grid.crossing(at));
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<double> round_levels(double low, double high, int most) {
  if (!(high > low) || most < 1) return {};
  double step = std::pow(10.0, std::floor(std::log10((high - low) / most)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    if (factor * step * most >= high - low) {
      step *= factor;
      break;
    }
  }
  std::vector<double> levels;
  for (double k = std::floor(low / step) + 1.0; k * step < high; ++k) {
    levels.push_back(k * step);
  }
  return levels;
}

}  // namespace sixdial::report
