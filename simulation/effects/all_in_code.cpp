// The effects that have a row of statements.
#include <algorithm>
#include <array>

#include "simulation/effect_in_code.h"

namespace sixdial::simulation {

extern constinit const EffectInCode base_drift_in_code, frame_skew_in_code,
    instrument_drift_in_code, instrument_scale_in_code, instrument_step_in_code,
    joint_backlash_in_code, joint_coupling_in_code, joint_curve_in_code,
    joint_eccentricity_in_code, joint_gain_in_code, joint_gravity_compliance_in_code,
    joint_second_harmonic_in_code, link_thermal_growth_in_code, passive_clearance_in_code,
    step_in_code;

namespace {
constexpr std::array kAll{
    &base_drift_in_code,
    &frame_skew_in_code,
    &instrument_drift_in_code,
    &instrument_scale_in_code,
    &instrument_step_in_code,
    &joint_backlash_in_code,
    &joint_coupling_in_code,
    &joint_curve_in_code,
    &joint_eccentricity_in_code,
    &joint_gain_in_code,
    &joint_gravity_compliance_in_code,
    &joint_second_harmonic_in_code,
    &link_thermal_growth_in_code,
    &passive_clearance_in_code,
    &step_in_code};
}  // namespace

const EffectInCode* find_effect_in_code(std::string_view cause) {
  const auto* const found =
      std::ranges::find(kAll, cause, [](const EffectInCode* each) { return each->cause; });
  return found == kAll.end() ? nullptr : *found;
}

}  // namespace sixdial::simulation
