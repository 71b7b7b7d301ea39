#include "report/words/estimate_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "geometry/units.h"

namespace sixdial::report {

std::string estimate_summary(const studies::EstimateSummary& estimate) {
  std::string text = fmt::format(
      "estimate after {} samples: position sd {:.4f} mm on average, {:.4f} mm at worst; "
      "condition {}",
      estimate.samples, estimate.position_sd_mean_mm, estimate.position_sd_max_mm,
      estimate.condition ? fmt::format("{:.0f}", *estimate.condition)
                         : std::string("infinite"));
  if (!estimate.undetermined.empty()) {
    text += fmt::format("; not determined yet: {}", fmt::join(estimate.undetermined, ", "));
  }
  if (estimate.set_aside > 0) text += fmt::format("; {} set aside", estimate.set_aside);
  if (estimate.last_times_usual) {
    text += estimate.last_unusual ? fmt::format(
                                        "; the last looks {:.0f} times usual: r to retake",
                                        *estimate.last_times_usual)
                                  : fmt::format(
                                        "; the last residual is {:.1f} times the usual",
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
        shown.per_unit * each.value, shown.per_unit * each.sd, shown.name);
  }
  return lines;
}

}  // namespace sixdial::report
