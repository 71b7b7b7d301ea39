#include "cli/plan_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "cli/console.h"

namespace sixdial::cli {
namespace {

// The later in the list covers the earlier.
constexpr std::string_view kMarks = " o.x!@";

char mark_of(const std::string& state) {
  if (state == "done") return 'o';
  if (state == "suspect") return '!';
  return state == "left" ? 'x' : '.';
}

}  // namespace

PlanMap::Key PlanMap::key_of(const Json& point) {
  return {
      point["set"].get<std::string>(), point["point"].get<int>(), point["repeat"].get<int>()};
}

void PlanMap::add(const Json& points) {
  for (const Json& each : points) {
    points_[key_of(each)] = {
        each["target_mm"][0].get<double>(), each["target_mm"][1].get<double>(),
        each["state"].get<std::string>()};
  }
}

void PlanMap::take_sample(const Json& sample) {
  mark(sample, sample.value("doubt", std::string()).empty() ? "done" : "suspect");
}

void PlanMap::mark(const Json& point, const std::string& state) {
  const auto found = points_.find(key_of(point));
  if (found != points_.end()) found->second.state = state;
}

std::vector<std::string> PlanMap::lines(
    std::size_t width, std::size_t height, const Json& next) const {
  constexpr std::size_t kLeastWidth = 20, kLeastHeight = 6;
  if (points_.empty() || width < kLeastWidth || height < kLeastHeight) return {};
  constexpr double kFar = std::numeric_limits<double>::max();
  double x0 = kFar, x1 = -kFar, y0 = kFar, y1 = -kFar;
  for (const auto& [key, point] : points_) {
    x0 = std::min(x0, point.x_mm);
    x1 = std::max(x1, point.x_mm);
    y0 = std::min(y0, point.y_mm);
    y1 = std::max(y1, point.y_mm);
  }
  const auto legend = wrapped("o done . open ! suspect x skipped @ next", width);
  const std::size_t columns = width - 2, rows = height - 2 - legend.size();
  std::vector<std::string> cells(rows, std::string(columns, ' '));
  const auto put = [&](double x_mm, double y_mm, char mark) {
    const auto at = [](double value, double low, double high, std::size_t count) {
      const double share = high > low ? (value - low) / (high - low) : 0.5;
      return static_cast<std::size_t>(std::lround(share * static_cast<double>(count - 1)));
    };
    char& cell = cells[rows - 1 - at(y_mm, y0, y1, rows)][at(x_mm, x0, x1, columns)];
    if (kMarks.find(mark) > kMarks.find(cell)) cell = mark;
  };
  for (const auto& [key, point] : points_) put(point.x_mm, point.y_mm, mark_of(point.state));
  if (next.is_object()) {
    const auto found = points_.find(key_of(next));
    if (found != points_.end()) put(found->second.x_mm, found->second.y_mm, '@');
  }
  std::vector<std::string> lines;
  const std::string edge =
      fmt::format("x {:.0f} to {:.0f}, y {:.0f} to {:.0f} mm", x0, x1, y0, y1);
  lines.push_back(fmt::format("+{:-<{}.{}}+", edge, columns, columns));
  for (const std::string& row : cells) lines.push_back("|" + row + "|");
  lines.push_back("+" + std::string(columns, '-') + "+");
  lines.insert(lines.end(), legend.begin(), legend.end());
  return lines;
}

}  // namespace sixdial::cli
