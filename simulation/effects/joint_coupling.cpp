// A wrist's gears or a belt pass a share of one joint's turn on to another: q_i += k q_j.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"k", "1", 1e-3},
};

/// Every two different turning joints of a robot whose joints stand one after the other.
std::vector<Place> places(const geometry::Rig& rig) {
  std::vector<Place> result;
  if (rig.robot.model->kind->has_passive_joints) return result;
  const std::vector<Place> joints = at_each_turning_joint(rig);
  for (const Place& driven : joints) {
    for (const Place& other : joints) {
      if (driven.joint == other.joint) continue;
      Place both = driven;
      both.name += "," + other.name;
      both.other_joint = other.joint;
      result.push_back(std::move(both));
    }
  }
  return result;
}

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  scene.q[place.joint] += x[0] * scene.q[place.other_joint];
}

}  // namespace

extern constinit const Effect joint_coupling;
constinit const Effect joint_coupling{
    .cause = "joint_coupling",
    .in_words = "coupling of joints",
    .in_words_with_place = "coupling of {place}",
    .places = places,
    .parameters = kParameters,
    .needs = kNothing,
    .before_kinematics = bend_kinematics,
    .size = "{k}",
    .plot = {Shows::kJointAngle, Against::kOtherJoint},
    .twin = "joint_coupling",
    .signature = "An error of one joint's angle in proportion to another joint's angle.",
    .consequence = "The tool turns, or is off, by where another joint stands.",
    .advice =
        "Check the coupling ratio of the wrist in the controller, or the belt that passes the "
        "other joint.",
    .why_not_learned = "",
    .told_apart =
        "A wrong ratio goes by the joint's own angle. Neighbouring joints with parallel axes "
        "look alike.",
    .helps = "Poses in which the two joints move independently over their whole ranges."};

extern constinit const EffectInCode joint_coupling_in_code;
constinit const EffectInCode joint_coupling_in_code{
    .cause = "joint_coupling", .at = [](const Place&) -> EffectStatements {
      return {.joints = "q[{joint}] += {0} * q[{other}]"};
    }};

}  // namespace sixdial::simulation
