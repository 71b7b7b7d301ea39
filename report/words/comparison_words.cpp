#include "report/words/comparison_words.h"

#include <fmt/format.h>

#include "report/words/rig_words.h"
#include "report/words/warning_words.h"

namespace sixdial::report {
namespace {

std::string three_figures(const std::optional<calibration::ErrorStats>& set) {
  if (!set) return fmt::format("{0:>9}{0:>9}{0:>9}", "-");
  return fmt::format("{:9.4f}{:9.4f}{:9.4f}", set->mean_mm, set->std_mm, set->max_mm);
}

/// Where the session has no positions, what is left of the raw readings tells methods apart.
std::string left_of_readings(const studies::ComparedRow& method) {
  if (method.g1 || method.g2 || !method.robot) return "";
  return fmt::format("  readings {:.4f} mm rms", method.robot->objective_rmse_mm);
}

}  // namespace

std::string comparison_text(const studies::ComparisonResult& result) {
  std::string text = result.warnings ? warnings_text(*result.warnings) : std::string();
  if (!text.empty()) text += '\n';
  text += fmt::format(
      "{:<24}{:^27}  {:^27}\n{:<24}{:>9}{:>9}{:>9}  {:>9}{:>9}{:>9}{:>10}\n",
      "position error, mm", "G1 calibration", "G2 validation", "method", "mean", "std", "max",
      "mean", "std", "max", "time, s");
  for (const studies::ComparedRow& method : result.methods) {
    text += fmt::format(
        "{:<24}{}  {}{:10.4f}{}{}\n", method.id, three_figures(method.g1),
        three_figures(method.g2), method.seconds(),
        method.id == result.best ? "  best on G2" : "", left_of_readings(method));
  }
  if (const std::string rig = result.rig ? rig_in_words(*result.rig) : ""; !rig.empty()) {
    text += rig + '\n';
  }
  return text;
}

const char* before_in_words(bool before_uses_targets) {
  return before_uses_targets ? "measured minus target" : "measured minus nominal model";
}

}  // namespace sixdial::report
