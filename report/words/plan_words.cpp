#include "report/words/plan_words.h"

#include <fmt/format.h>

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

}  // namespace sixdial::report
