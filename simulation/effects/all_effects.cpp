// The effects that the program brings with it, in alphabetical order.
#include <array>

#include "simulation/catalogue.h"

namespace sixdial::simulation {

extern constinit const Effect base_drift, cuboid_offset, cuboid_size, cuboid_squareness,
    dial_curve, dial_cyclic, dial_gain, dial_hysteresis, dial_lean, dial_mount, dial_swap,
    frame_skew, instrument_drift, instrument_scale, instrument_step, joint_backlash,
    joint_compliance, joint_coupling, joint_curve, joint_eccentricity, joint_gain,
    joint_gravity_compliance, joint_second_harmonic, link_thermal_growth, passive_clearance,
    step, tip_radius;

namespace {
constexpr std::array kAll{
    &base_drift,
    &cuboid_offset,
    &cuboid_size,
    &cuboid_squareness,
    &dial_curve,
    &dial_cyclic,
    &dial_gain,
    &dial_hysteresis,
    &dial_lean,
    &dial_mount,
    &dial_swap,
    &frame_skew,
    &instrument_drift,
    &instrument_scale,
    &instrument_step,
    &joint_backlash,
    &joint_compliance,
    &joint_coupling,
    &joint_curve,
    &joint_eccentricity,
    &joint_gain,
    &joint_gravity_compliance,
    &joint_second_harmonic,
    &link_thermal_growth,
    &passive_clearance,
    &step,
    &tip_radius};
}  // namespace

std::span<const Effect* const> built_in_effects() { return kAll; }

}  // namespace sixdial::simulation
