#include "report/words/compensation_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

#include "geometry/coverage.h"
#include "geometry/units.h"

namespace sixdial::report {
namespace {

/// "q1" and "rad" of "q1_rad".
std::pair<std::string_view, std::string_view> name_and_unit(std::string_view column) {
  const std::size_t at = column.rfind('_');
  return {column.substr(0, at), column.substr(at + 1)};
}

/// "q1 1.234567890  q2 0.9 rad"; of joints of several units each with its own.
std::string joints_text(const studies::CommandedTarget& at) {
  std::vector<std::string> columns = at.joints.value_or(std::vector<std::string>());
  for (std::size_t i = columns.size(); i < at.theta_rad.size(); ++i) {
    columns.push_back(fmt::format("theta{}_rad", i + 1));
  }
  const bool angles = std::ranges::all_of(
      columns, [](const std::string& each) { return name_and_unit(each).second == "rad"; });
  std::string text;
  for (std::size_t i = 0; i < at.theta_rad.size(); ++i) {
    const auto [name, unit] = name_and_unit(columns[i]);
    text += fmt::format("{}{} {:.9f}", i == 0 ? "" : "  ", name, at.theta_rad[i]);
    if (!angles) text += fmt::format(" {}", unit);
  }
  return angles ? text + " rad" : text;
}

}  // namespace

std::string compensation_text(const studies::CommandedTarget& at) {
  using geometry::kCoverage;
  using geometry::kDegPerRad;
  std::string text =
      fmt::format("{} for ({:.6f}) mm", joints_text(at), fmt::join(at.target_mm, ", "));
  if (at.turn) {
    const Eigen::Vector3d angles_deg = kDegPerRad * at.turn->angles_rad;
    text += fmt::format(
        " turned by ({:.6f}) deg, {}", fmt::join(angles_deg, ", "), at.turn->orientation);
  }
  // A robot in space has no elbow sides to name.
  if (at.target_mm.size() == 2) text += " in mode " + geometry::to_string(at.mode);
  text += "; nominal";
  for (const double value : at.nominal_theta_rad) text += fmt::format(" {:.9f}", value);
  text += fmt::format("; closes to {:.1e} mm", at.closure_mm);
  if (at.closure_rad) text += fmt::format(" and {:.1e} deg", kDegPerRad * *at.closure_rad);
  text += '\n';
  if (!at.uncertainty) return text;
  text += fmt::format(
      "the model knows the place to {:.4f} mm", kCoverage * at.uncertainty->position_sd_mm);
  if (const auto turn_sd_rad = at.uncertainty->turn_sd_rad) {
    text += fmt::format(" and the turn to {:.5f} deg", kCoverage * kDegPerRad * *turn_sd_rad);
  }
  return text + fmt::format(
                    " (expanded uncertainty, k = {:.0f}), without what the robot does not "
                    "repeat\n",
                    kCoverage);
}

}  // namespace sixdial::report
