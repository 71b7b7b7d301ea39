// The effect of CONTRIBUTING.md's "Add an effect": three waves a turn.
//   theta += a sin 3 theta + b cos 3 theta
#include <cmath>

#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"a", "rad", 5e-4},
    {"b", "rad", 5e-4},
};

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  const double q = scene.q[place.joint];
  scene.q[place.joint] += x[0] * std::sin(3 * q) + x[1] * std::cos(3 * q);
}

}  // namespace

extern constinit const Effect joint_third_harmonic;
constinit const Effect joint_third_harmonic{
    .cause = "joint_third_harmonic",
    .in_words = "third harmonic",
    .in_words_with_place = "third harmonic of {place}",
    .places = at_each_joint,
    .parameters = kParameters,
    .before_kinematics = bend_kinematics,
    .plot = {Shows::kJointAngle, Against::kJointAngle},
    .twin = "joint_third_harmonic",
    .signature = "The residual has three waves over a turn of one joint.",
    .consequence = "Parts are off by an amount that depends on that joint's angle.",
    .advice = "Look at the gear's wave generator and the encoder's mounting.",
    .why_not_learned = "",
    .told_apart = "From the second harmonic by the number of waves over a turn.",
    .helps = "A wide range of that joint's angle, in several working modes."};

}  // namespace sixdial::simulation
