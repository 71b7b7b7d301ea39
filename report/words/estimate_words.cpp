#include "report/words/estimate_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "geometry/coverage.h"
#include "geometry/units.h"

namespace sixdial::report {

using geometry::kCoverage;

std::string estimate_summary(const studies::EstimateSummary& estimate) {
  std::string text = fmt::format(
      "estimate after {} samples: positions are known to {:.4f} mm on average and {:.4f} mm at "
      "worst "
      "(k = {:.0f}){}; condition number {}",
      estimate.samples, kCoverage * estimate.position_sd_mean_mm,
      kCoverage * estimate.position_sd_max_mm, kCoverage,
      estimate.position_sd_rig_mm
          ? fmt::format(", the rig alone {:.4f} mm", kCoverage * *estimate.position_sd_rig_mm)
          : std::string(),
      estimate.condition ? fmt::format("{:.0f}", *estimate.condition)
                         : std::string("infinite"));
  if (!estimate.undetermined.empty()) {
    text += fmt::format("; not determined yet: {}", fmt::join(estimate.undetermined, ", "));
  }
  if (estimate.set_aside > 0)
    text += fmt::format("; {} samples not used, too far off", estimate.set_aside);
  if (estimate.last_times_usual) {
    text += estimate.last_unusual
                ? fmt::format(
                      "; the last sample is {:.0f} times as far off as usual: "
                      "r measures it again",
                      *estimate.last_times_usual)
                : fmt::format(
                      "; the last sample is {:.1f} times as far off as usual",
                      *estimate.last_times_usual);
  }
  return text;
}

std::vector<std::string> estimate_parameters(
    const studies::EstimateSummary& estimate, std::size_t in_line) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const studies::EstimatedParameter& each = estimate.parameters[i];
    const geometry::ShownUnit shown = geometry::shown_unit(each.unit);
    if (i % in_line == 0) lines.emplace_back();
    lines.back() += fmt::format(
        "{}{} {:.4f} +- {:.4f} {}", i % in_line == 0 ? "  " : "   ", each.name,
        shown.per_unit * each.value, kCoverage * shown.per_unit * each.sd, shown.name);
  }
  return lines;
}

}  // namespace sixdial::report
