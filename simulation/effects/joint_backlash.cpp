// Lost motion: theta -= (b/2) direction of arrival.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"b", "rad", 4e-4, true},
};

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  scene.q[place.joint] -= 0.5 * x[0] * sample.approach[place.joint];
}

std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  return of_joint(kParameters[k], place);
}

}  // namespace

extern constinit const Effect joint_backlash;
constinit const Effect joint_backlash{
    .cause = "joint_backlash",
    .in_words = "backlash",
    .in_words_with_place = "backlash of {place}",
    .places = at_each_joint,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kApproach,
    .never_negative = true,
    .before_kinematics = bend_kinematics,
    .size = "{b}",
    .plot = {Shows::kJointAngle, Against::kJointAngle, Groups::kJointApproach},
    .twin = "joint_backlash",
    .signature =
        "Two parallel levels of residual: one when the joint arrives turning up, one when "
        "turning down.",
    .consequence = "A part depends on the side from which each position was approached.",
    .advice =
        "Take up the play (preload, gear mesh, coupling), or always approach from the same "
        "side.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with two different "
        "errors, by the direction of arrival.",
    .told_apart =
        "Clearance of the elbows follows the tool's direction of travel, hysteresis one "
        "dial's plunger; backlash follows one joint's direction.",
    .helps = "Every place approached from both sides of that joint (`--approach both-sides`)."};

extern constinit const EffectInCode joint_backlash_in_code;
constinit const EffectInCode joint_backlash_in_code{
    .cause = "joint_backlash", .at = [](const Place&) -> EffectStatements {
      return {.joints = "q[{joint}] -= 0.5 * {0} * approach[{joint}]"};
    }};

}  // namespace sixdial::simulation
