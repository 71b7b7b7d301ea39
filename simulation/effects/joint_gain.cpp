// Encoder or gear ratio off: theta += g (theta - mid). The middle is taken by the joint's
// offset.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"g", "1", 2e-3},
};

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  scene.q[place.joint] += x[0] * scene.q[place.joint];
}

}  // namespace

extern constinit const Effect joint_gain;
constinit const Effect joint_gain{
    .cause = "joint_gain",
    .in_words = "wrong ratio",
    .in_words_with_place = "wrong ratio of {place}",
    .places = at_each_joint,
    .parameters = kParameters,
    .needs = kNothing,
    .before_kinematics = bend_kinematics,
    .size = "{g}",
    .plot = {Shows::kJointAngle, Against::kJointAngle},
    .twin = "joint_gain",
    .signature = "An angle error that grows in proportion to the joint's angle.",
    .consequence = "Moves come out too long or too short in proportion to the joint's travel.",
    .advice = "Check the encoder's counts per turn and the gear ratio in the controller.",
    .why_not_learned = "",
    .told_apart =
        "An eccentricity over a small range is nearly a straight line as well; the encoder "
        "offset takes up the rest.",
    .helps = "The widest range of that joint, in several working modes."};

extern constinit const EffectInCode joint_gain_in_code;
constinit const EffectInCode joint_gain_in_code{
    .cause = "joint_gain", .at = [](const Place&) -> EffectStatements {
      return {.joints = "q[{joint}] += {0} * q[{joint}]"};
    }};

}  // namespace sixdial::simulation
