#include "diagnosis/exchanged_dials.h"

#include <utility>

#include "diagnosis/baseline.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {

std::optional<Hypothesis> find_exchanged_dials(
    Readings& readings, const std::vector<Hypothesis>& hypotheses, JointFit& baseline) {
  if (!looks_wrong(readings, baseline)) return std::nullopt;
  std::optional<Hypothesis> found;
  std::optional<Readings> best_readings;
  JointFit best = baseline;
  double best_likelihood = baseline.log_likelihood + kExchangeLogOdds;
  for (const Hypothesis& each : hypotheses) {
    if (!each.effect->exchanges_dials) continue;
    Readings swapped = readings.with_swapped_dials(each.place.dial, each.place.other_dial);
    for (const simulation::ModelVector& start : {baseline.model, readings.model().nominal()}) {
      JointFit fit = fit_jointly(swapped, start, {});
      if (fit.log_likelihood <= best_likelihood) continue;
      best_likelihood = fit.log_likelihood;
      best = std::move(fit);
      best_readings = swapped;
      found = each;
    }
  }
  if (found) {
    readings = std::move(*best_readings);
    baseline = std::move(best);
  }
  return found;
}

}  // namespace sixdial::diagnosis
