// A harmonic drive's twice-a-turn error: theta += a sin 2 theta + b cos 2 theta.
#include <cmath>
#include <numbers>

#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"a", "rad", 5e-4},
    {"b", "rad", 5e-4},
};

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  const double twice = 2 * scene.q[place.joint];
  scene.q[place.joint] += x[0] * std::sin(twice) + x[1] * std::cos(twice);
}

}  // namespace

extern constinit const Effect joint_second_harmonic;
constinit const Effect joint_second_harmonic{
    .cause = "joint_second_harmonic",
    .in_words = "second harmonic",
    .in_words_with_place = "second harmonic of {place}",
    .places = at_each_turning_joint,
    .parameters = kParameters,
    .needs = kNothing,
    .before_kinematics = bend_kinematics,
    .size = "amplitude {a,b}",
    .plot = {Shows::kJointAngle, Against::kJointAngle},
    .twin = "joint_second_harmonic",
    .signature =
        "A smooth wave over one joint's angle, twice a turn, the same whenever the joint "
        "passes there.",
    .consequence =
        "Parts are off by a smooth, repeatable amount that changes across the workspace.",
    .advice =
        "Check the harmonic drive's assembly and preload, or enter the wave as an angle "
        "correction.",
    .why_not_learned = "",
    .told_apart =
        "An eccentricity is half as fast; over a small range both look alike and are given as "
        "a set.",
    .helps = "The widest range of that joint, in several working modes."};

extern constinit const EffectInCode joint_second_harmonic_in_code;
constinit const EffectInCode joint_second_harmonic_in_code{
    .cause = "joint_second_harmonic", .at = [](const Place&) -> EffectStatements {
      return {
          .joints = "q[{joint}] += {0} * sin(2.0 * q[{joint}]) + {1} * cos(2.0 * q[{joint}])"};
    }};

}  // namespace sixdial::simulation
