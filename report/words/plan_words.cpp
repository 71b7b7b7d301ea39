#include "report/words/plan_words.h"

#include <fmt/format.h>

namespace sixdial::report {
namespace {

std::string name_of(const studies::PlacedCause& placed) {
  return fmt::format("{} at {}", placed.cause, placed.where);
}

}  // namespace

std::string next_plan_text(const studies::NextPlanFigures& figures) {
  std::string text = fmt::format(
      "{} samples of G1: position sd over the workspace {:.4f} mm on average, {:.4f} mm at "
      "worst",
      figures.samples, figures.now.mean_mm, figures.now.max_mm);
  if (figures.after) {
    text += fmt::format(
        "; with these {} ({}-optimal): {:.4f} and {:.4f} mm", figures.points,
        calibration::to_string(figures.criterion), figures.after->mean_mm,
        figures.after->max_mm);
  }
  return text;
}

std::string separation_text(const studies::SeparationFigures& figures) {
  std::string text = figures.rival ? fmt::format(
                                         "{} and {} are tied.", name_of(figures.separates),
                                         name_of(*figures.rival))
                                   : fmt::format(
                                         "No causes are tied. This session is blindest to {}",
                                         name_of(figures.separates));
  if (!figures.rival) {
    text += figures.size_assumed
                ? fmt::format(" (taken as {:.3g} {}).", *figures.size_assumed, figures.unit)
                : std::string(".");
  }
  return text +
         fmt::format(
             " Expected log odds now {:.1f}, with these {} points {:.1f} (5 is certain).",
             figures.log_odds_now, figures.points, figures.log_odds_after);
}

}  // namespace sixdial::report
