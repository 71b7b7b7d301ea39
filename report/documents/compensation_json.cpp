#include "report/documents/compensation_json.h"

#include "report/documents/fields.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::AskedTurn>& turn) {
  at("angles_rad", turn.angles_rad);
  at("orientation", turn.orientation);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::TargetUncertainty>& known) {
  at("position_sd_mm", known.position_sd_mm);
  at.maybe("turn_sd_rad", known.turn_sd_rad);
}

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
  at.maybe("turn", commanded.turn);
  at.maybe("closure_rad", commanded.closure_rad);
  at.maybe("uncertainty", commanded.uncertainty);
  at.maybe("joints", commanded.joints);
}

Json to_json(const studies::CommandedTarget& commanded) { return write(commanded); }

studies::CommandedTarget commanded_target_from_json(const Json& json) {
  return read<studies::CommandedTarget>(json, "sixdial.compensation");
}

}  // namespace sixdial::report
