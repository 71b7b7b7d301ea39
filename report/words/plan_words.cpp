#include "report/words/plan_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/coverage.h"
#include "geometry/units.h"
#include "simulation/effect_words.h"

namespace sixdial::report {
namespace {

using geometry::kCoverage;

std::string name_of(const studies::PlacedCause& placed) {
  return fmt::format("{} at {}", placed.cause, placed.where);
}

/// Poses of each socket, and what is known of their distances.
std::string socket_lines(const studies::SocketPlanFigures& figures) {
  std::string text;
  for (const studies::PlannedSocket& each : figures.sockets) {
    text += fmt::format(
        "{} at ({:.0f}, {:.0f}, {:.0f}) mm: {} poses, stem {:.0f} to {:.0f} deg off the axis\n",
        each.name, each.at_mm.x(), each.at_mm.y(), each.at_mm.z(), each.poses,
        geometry::kDegPerRad * each.least_lean_rad, geometry::kDegPerRad * each.most_lean_rad);
  }
  for (const studies::PlannedDistance& each : figures.distances) {
    text += fmt::format(
        "{} to {}: {:.3f} mm, known to {} mm\n", each.first, each.second, each.mm,
        simulation::in_digits(each.sd_mm, 3));
    constexpr double kNear_mm = 20.0;  // places are given to a few centimetres
    if (std::abs(each.places_mm - each.mm) > kNear_mm) {
      text += fmt::format(
          "  The places given are {:.0f} mm apart: is it these two sockets, and mm?\n",
          each.places_mm);
    }
  }
  return text;
}

/// What the plan leaves open, and what to do about it.
std::string open_lines(const studies::SocketPlanFigures& figures) {
  std::string text;
  if (figures.scale_is_open) {
    text +=
        "The scale stays open: no distance of two sockets is known, and an arm that is larger "
        "in all its lengths fits as well. Measure one, then sixdial plan sockets ... "
        "--distance "
        "MM --distance-sd MM\n";
  }
  const auto plan = std::ranges::find_if(figures.stages, [&](const auto& stage) {
    return !figures.sockets.empty() && stage.poses == figures.sockets.front().poses;
  });
  if (plan == figures.stages.end() || plan->open.empty()) return text;
  text += fmt::format(
      "Not told by these poses, and held at nominal ({:.2f} mm of the above):\n",
      kCoverage * plan->open_mm.value_or(0.0));
  for (const std::string& each : plan->open) text += "  " + each + "\n";
  if (plan->open.size() > (figures.scale_is_open ? 1U : 0U)) {
    text +=
        "Sockets at other heights and distances from the arm, a wider cone or more poses may "
        "tell it.\n";
  }
  return text;
}

}  // namespace

std::string next_plan_text(const studies::NextPlanFigures& figures) {
  std::string text = fmt::format(
      "{} samples of G1: positions over the workspace are known to {:.4f} mm on average and "
      "{:.4f} mm at worst (expanded uncertainty, k = {:.0f})",
      figures.samples, kCoverage * figures.now.mean_mm, kCoverage * figures.now.max_mm,
      kCoverage);
  if (figures.after) {
    text += fmt::format(
        "; with these {} points ({}-optimal) to {:.4f} and {:.4f} mm", figures.points,
        calibration::to_string(figures.criterion), kCoverage * figures.after->mean_mm,
        kCoverage * figures.after->max_mm);
  }
  return text;
}

std::string separation_text(const studies::SeparationFigures& figures) {
  std::string text = figures.rival ? fmt::format(
                                         "{} and {} are tied.", name_of(figures.separates),
                                         name_of(*figures.rival))
                                   : fmt::format(
                                         "No two causes are tied. The cause that this session "
                                         "shows worst is {}",
                                         name_of(figures.separates));
  if (!figures.rival) {
    text += figures.size_assumed
                ? fmt::format(
                      " (taken as {} {}).", simulation::in_digits(*figures.size_assumed, 3),
                      figures.unit)
                : std::string(".");
  }
  return text + fmt::format(
                    " Expected log odds: {:.1f} now, {:.1f} with these {} points (from 5 on a "
                    "name is certain).",
                    figures.log_odds_now, figures.log_odds_after, figures.points);
}

std::string rig_check_text(const studies::RigCheckFigures& figures) {
  std::string text =
      "What the rig itself leaves open, once so many points of this plan are measured:\n";
  for (const studies::RigCheckStage& stage : figures.stages) {
    text += fmt::format(
        "{:5d} points: {:3.0f} % of the rig's uncertainty remains; the tool's position is "
        "known to "
        "{:.4f} mm\n",
        stage.points, 100 * stage.left, stage.position_mm);
  }
  text += fmt::format(
      "(one standard deviation, mean over the area; with a rig exactly as its file says: "
      "{:.4f} "
      "mm)\n",
      figures.exact_rig_mm);
  constexpr double kHardly = 0.9;
  std::vector<std::string> hardly;
  bool stated = false;
  for (const studies::RigCheckQuantity& each : figures.quantities) {
    stated = stated || each.stated;
    if (each.left > kHardly) {
      hardly.push_back(
          fmt::format("{} ({} {})", each.name, simulation::in_digits(each.sd, 3), each.unit));
    }
  }
  if (!stated) {
    text +=
        "The rig file states no deviations: those of a ruler, a square and a gauge block "
        "were taken.\n";
  }
  if (hardly.empty()) return text + "Every quantity of the rig comes out of these points.";
  return text +
         fmt::format(
             "No pose tells more than a tenth of: {}. Measure these by hand: a lean by a "
             "shim of known thickness under one side of the dial's holder, a place by a "
             "gauge block, the cuboid by a micrometer and a square "
             "(doc/manual/mounting.md).",
             fmt::join(hardly, ", "));
}

std::string socket_plan_text(const studies::SocketPlanFigures& figures) {
  std::string text = socket_lines(figures);
  text += fmt::format(
      "With a ball that comes back to within {} mm (standard deviation of a "
      "coordinate{}):\n",
      simulation::in_digits(figures.seat_sd_mm, 3),
      figures.seat_sd_assumed ? ", assumed: sixdial plan sockets ... --seat-sd says it" : "");
  for (const studies::SocketStage& stage : figures.stages) {
    text += fmt::format(
        "{:5d} poses of each socket: the tool is known to {:.3f} mm on average, {:.3f} mm at "
        "worst\n",
        stage.poses, kCoverage * stage.position.mean_mm, kCoverage * stage.position.max_mm);
  }
  text += fmt::format(
      "(expanded uncertainty, k = {:.0f}, anywhere in the joints' ranges, once the arm is "
      "registered where it works)\n",
      kCoverage);
  text += open_lines(figures);
  text += "Of the parameters, one standard deviation:\n";
  for (const studies::PlannedParameter& each : figures.parameters) {
    const auto unit = geometry::shown_unit(each.unit);
    text += fmt::format(
        "  {:<10} {:8.4f} {}{}\n", each.name, unit.per_unit * each.sd, unit.name,
        each.open ? ", partly open" : "");
  }
  return text + "Where the arm stands is not asked: base_... keep their values.";
}

}  // namespace sixdial::report
