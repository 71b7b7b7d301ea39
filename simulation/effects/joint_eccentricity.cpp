// Gear or encoder runs out, once a turn: theta += a sin theta + b cos theta.
#include <cmath>
#include <numbers>

#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"a", "rad", 2e-3},
    {"b", "rad", 2e-3},
};

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  const double theta = scene.q[place.joint];
  scene.q[place.joint] += x[0] * std::sin(theta) + x[1] * std::cos(theta);
}

}  // namespace

extern constinit const Effect joint_eccentricity;
constinit const Effect joint_eccentricity{
    .cause = "joint_eccentricity",
    .in_words = "eccentricity",
    .in_words_with_place = "eccentricity of {place}",
    .places = at_each_turning_joint,
    .parameters = kParameters,
    .needs = kNothing,
    .before_kinematics = bend_kinematics,
    .size = "amplitude {a,b}",
    .plot = {Shows::kJointAngle, Against::kJointAngle},
    .twin = "joint_eccentricity",
    .signature =
        "A smooth wave over one joint's angle, once a turn, the same whenever the joint passes "
        "there.",
    .consequence =
        "Parts are off by a smooth, repeatable amount that changes across the workspace.",
    .advice =
        "Check the run-out of the joint's gear or encoder disc, re-centre it, or enter the "
        "wave as an angle correction.",
    .why_not_learned = "",
    .told_apart =
        "The second harmonic turns twice as fast; over less than half a turn of the joint "
        "both, and a wrong ratio, look alike and are given as a set.",
    .helps = "The widest range of that joint that the dials allow, in several working modes."};

extern constinit const EffectInCode joint_eccentricity_in_code;
constinit const EffectInCode joint_eccentricity_in_code{
    .cause = "joint_eccentricity", .at = [](const Place&) -> EffectStatements {
      return {.joints = "q[{joint}] += {0} * sin(q[{joint}]) + {1} * cos(q[{joint}])"};
    }};

}  // namespace sixdial::simulation
