#include "report/words/comparison_words.h"

#include <fmt/format.h>

#include "report/words/warning_words.h"

namespace sixdial::report {
namespace {

std::string three_figures(const std::optional<calibration::ErrorStats>& set) {
  if (!set) return fmt::format("{0:>9}{0:>9}{0:>9}", "-");
  return fmt::format("{:9.4f}{:9.4f}{:9.4f}", set->mean_mm, set->std_mm, set->max_mm);
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
        "{:<24}{}  {}{:10.4f}{}\n", method.id, three_figures(method.g1),
        three_figures(method.g2), method.seconds(),
        method.id == result.best ? "  best on G2" : "");
  }
  return text;
}

const char* before_in_words(bool before_uses_targets) {
  return before_uses_targets ? "measured minus target" : "measured minus nominal model";
}

}  // namespace sixdial::report
