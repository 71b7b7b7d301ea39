#include "report/words/plan_words.h"

#include <fmt/format.h>

#include <vector>

#include "geometry/coverage.h"

namespace sixdial::report {
namespace {

using geometry::kCoverage;

std::string name_of(const studies::PlacedCause& placed) {
  return fmt::format("{} at {}", placed.cause, placed.where);
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
                ? fmt::format(" (taken as {:.3g} {}).", *figures.size_assumed, figures.unit)
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
      hardly.push_back(fmt::format("{} ({:.3g} {})", each.name, each.sd, each.unit));
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

}  // namespace sixdial::report
