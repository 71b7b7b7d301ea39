#include "report/documents/estimate_json.h"

#include "report/documents/fields.h"
#include "report/documents/rig_seen_json.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::EstimatedParameter>& parameter) {
  at("name", parameter.name);
  at("unit", parameter.unit);
  at("value", parameter.value);
  at("sd", parameter.sd);
  at.maybe("meaning", parameter.meaning);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::EstimateSummary>& estimate) {
  at("samples", estimate.samples);
  at("set_aside", estimate.set_aside);
  at("noise_times", estimate.noise_times);
  at("parameters", estimate.parameters);
  at.inner("position_sd_mm", [&](auto& sd) {
    sd("mean", estimate.position_sd_mean_mm);
    sd("max", estimate.position_sd_max_mm);
    sd("worst_mm", estimate.worst_mm);
    sd.maybe("of_rig", estimate.position_sd_rig_mm);
  });
  at.maybe("rig", estimate.rig);
  at("condition", estimate.condition);
  at("undetermined", estimate.undetermined);
  at("last_times_usual", estimate.last_times_usual);
  at("last_unusual", estimate.last_unusual);
}

Json to_json(const studies::EstimateSummary& estimate) { return write(estimate); }

studies::EstimateSummary estimate_from_json(const Json& json) {
  return read<studies::EstimateSummary>(json, "estimate");
}

}  // namespace sixdial::report
