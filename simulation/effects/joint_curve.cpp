// Gear, strain-wave drive or encoder errs within a turn: q += c(q), a smooth curve of the
// joint's own value with any number of waves.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"
#include "simulation/smooth_function.h"

namespace sixdial::simulation {
namespace {

/// As a finding says its size; what a fit has is in smooth_function.h.
constexpr EffectParameter kParameters[] = {
    {"half_span", "rad", 3e-4},
    {"rms", "rad", 2e-4},
    {"period", "rad", 0.1},
};

std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  return of_joint(kParameters[k], place);
}

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  scene.q[place.joint] += smooth_value(x, scene.q[place.joint]);
}

}  // namespace

extern constinit const Effect joint_curve;
constinit const Effect joint_curve{
    .cause = "joint_curve",
    .in_words = "error curve of a joint",
    .in_words_with_place = "error curve of {place}",
    .places = at_each_joint,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kNothing,
    .is_curve = true,
    .before_kinematics = bend_kinematics,
    .size = "half span {half_span}, rms {=rms}[, its strongest wave {=period} long]",
    .plot = {Shows::kJointAngle, Against::kJointAngle},
    .twin = "joint_fifth_harmonic",
    .signature =
        "A smooth curve over one joint's own value, often with many waves a turn, the same "
        "whenever the joint passes there.",
    .consequence =
        "Parts are off by a repeatable amount that changes quickly from place to place.",
    .advice =
        "Enter the curve as a correction of that joint if its controller takes one (the model "
        "of this diagnosis has it); else have the drive and its encoder checked.",
    .why_not_learned = "",
    .told_apart =
        "An eccentricity has one wave a turn, a second harmonic two: where these suffice they "
        "are named. A curve that another joint's angle would explain as well is tied.",
    .helps = "That joint over its whole range in small steps, the others where they vary."};

extern constinit const EffectInCode joint_curve_in_code;
constinit const EffectInCode joint_curve_in_code{
    .cause = "joint_curve", .at = [](const Place&) -> EffectStatements {
      return {.joints = "q[{joint}] += smooth_value({curve}, q[{joint}])"};
    }};

}  // namespace sixdial::simulation
