#include "diagnosis/search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "diagnosis/significance.h"

namespace sixdial::diagnosis {
namespace {

using simulation::Circumstance;
using simulation::Effect;

}  // namespace

std::string Hypothesis::name() const { return std::string(effect->cause) + "@" + place.name; }

std::vector<Hypothesis> hypotheses_for(
    const Readings& readings, std::vector<NotTestable>& not_testable) {
  const auto& samples = readings.circumstances();
  const auto varies = [&](auto&& value) {
    std::set<double> seen;
    for (const Circumstance& sample : samples) seen.insert(value(sample));
    return seen.size() > 1;
  };
  bool time = false, temperature = false;
  for (const auto& trial : readings.trials()) {
    time = time || trial.time_s.has_value();
    temperature = temperature || trial.temperature_c.has_value();
  }
  const bool temperature_varies =
      temperature && varies([](const Circumstance& s) { return s.temperature_degC; });
  std::vector<Hypothesis> result;
  for (const Effect* effect : simulation::all_effects()) {
    if (effect->is_curve) continue;  // found as something smooth
    for (const simulation::Place& place : effect->places(readings.model().rig())) {
      const Hypothesis each{effect, place};
      std::optional<WhyNotTestable> why;
      if ((effect->needs & simulation::kDials || place.dial >= 0) && !readings.has_dials()) {
        why = WhyNotTestable::kNoDials;
      } else if (effect->needs & simulation::kTemperature && !temperature_varies) {
        why =
            temperature ? WhyNotTestable::kTemperatureConstant : WhyNotTestable::kNoTemperature;
      } else if (effect->needs & simulation::kTime && !time) {
        why = WhyNotTestable::kNoTime;
      } else if (effect->needs & simulation::kApproach && place.joint >= 0) {
        const int joint = place.joint;
        std::map<double, int> counts;
        for (const Circumstance& sample : samples) ++counts[sample.approach[joint]];
        if (counts[1.0] < 3 || counts[-1.0] < 3) {
          const bool none = counts[1.0] + counts[-1.0] == 0;
          why = none ? WhyNotTestable::kNoApproach : WhyNotTestable::kOneApproach;
        }
      }
      if (why) {
        not_testable.push_back({each, *why});
      } else {
        result.push_back(each);
      }
    }
  }
  return result;
}

double family_p_value(const std::vector<Candidate>& candidates) {
  double smallest = 1.0;
  for (const Candidate& each : candidates) smallest = std::min(smallest, each.p_value);
  return p_value_of_best(smallest, static_cast<double>(candidates.size()));
}

}  // namespace sixdial::diagnosis
