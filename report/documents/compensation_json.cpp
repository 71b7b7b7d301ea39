#include "report/documents/compensation_json.h"

#include "report/documents/fields.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::CommandedTarget>& commanded) {
  at("target_mm", commanded.target_mm);
  at.named(
      "mode", commanded.mode,
      [](const geometry::WorkingMode& mode) { return geometry::to_string(mode); },
      geometry::working_mode_from);
  at.named(
      "by", commanded.by, [](studies::CompensateBy by) { return studies::to_string(by); },
      studies::compensate_by_from);
  at("theta_rad", commanded.theta_rad);
  at("nominal_theta_rad", commanded.nominal_theta_rad);
  at("closure_mm", commanded.closure_mm);
  at("iterations", commanded.iterations);
}

Json to_json(const studies::CommandedTarget& commanded) { return write(commanded); }

studies::CommandedTarget commanded_target_from_json(const Json& json) {
  return read<studies::CommandedTarget>(json, "sixdial.compensation");
}

}  // namespace sixdial::report
