// The step in which a dial's readings come, against the resolution that the rig file states: a
// controller that rounds, a dial of another type, or a slip in the file. The noise of rounding
// weighs every reading.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

/// Steps of dials [mm], coarse to fine; those of inch dials among them.
constexpr std::array kSteps_mm{1.0,     0.5,    0.2,  0.1,   0.05,    0.0254,
                               0.02,    0.0127, 0.01, 0.005, 0.00254, 0.002,
                               0.00127, 0.001,  5e-4, 2e-4,  1e-4};
/// Readings in steps of 0.001 are all multiples of 0.002 once in two to the power of this.
constexpr std::size_t kFewestReadings = 20;
constexpr double kWhole = 1e-3;   // of a step
constexpr double kCoarser = 1.5;  // times the stated resolution
constexpr double kFiner = 0.002;  // of it; a mean of readings has more digits than a reading

/// The coarsest step that all readings are multiples of; 0: none of those above.
double step_of(const std::set<double>& readings) {
  for (const double step : kSteps_mm) {
    const bool all = std::ranges::all_of(readings, [step](double reading) {
      const double steps = reading / step;
      return std::abs(steps - std::round(steps)) < kWhole;
    });
    if (all) return step;
  }
  return 0.0;
}

}  // namespace

void look_at_resolution(Look& look) {
  auto& dials = look.used.rig.dials;
  std::map<std::pair<double, double>, std::vector<std::string>>
      found;  // stated and seen [mm] -> dials
  for (std::size_t k = 0; k < dials.size(); ++k) {
    std::set<double> readings;
    for (const session::Sample& sample : look.used.samples) {
      if (sample.left_out || k >= sample.channels.size()) continue;
      const session::ChannelValue& each = sample.channels[k];
      if (each.value && each.quality != session::Quality::kBad) readings.insert(*each.value);
    }
    if (readings.size() < kFewestReadings) continue;
    const double stated = dials[k].resolution_mm;
    const double seen = step_of(readings);
    if (seen <= 0.0 || (seen < kCoarser * stated && seen > kFiner * stated)) continue;
    found[{stated, seen}].push_back(dials[k].id);
    dials[k].resolution_mm = seen;
  }
  for (const auto& [steps, names] : found) {
    look.tell(
        "resolution", Severity::kNote, Look::rig_key("resolution_mm"),
        {{"dials", dials_in_words(names)}, {"stated", steps.first}, {"seen", steps.second}});
  }
}

}  // namespace sixdial::studies::plausibility
