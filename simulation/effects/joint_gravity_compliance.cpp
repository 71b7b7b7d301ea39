// A joint gives under the weight of what it carries: q += moment / stiffness. Masses are not
// known: the links' share and the tool's are each fitted.
#include <cmath>
#include <utility>

#include "simulation/effect.h"
#include "simulation/effect_in_code.h"
#include "simulation/weight.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"links", "rad/m", 2e-4},
    {"tool", "rad/m", 2e-4},
};

/// Behind the last joint there is the tool alone: its own link ends on its axis, or nearly so.
bool carries_links(const Place& place) { return place.joint != place.other_joint; }

std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  if (k == 0 && !carries_links(place)) return std::nullopt;
  return kParameters[k];
}

/// Turning joints that carry weight: not one whose axis always stands upright.
std::vector<Place> places(const geometry::Rig& rig) {
  const geometry::RobotModel& robot = *rig.robot.model;
  if (robot.axes < 3 || robot.kind->has_passive_joints) return {};
  Eigen::VectorXd v = robot.nominal;  // upright, wherever the file has it stand
  for (std::size_t k = 0; k < robot.parameters.size(); ++k) {
    if (robot.parameters[k].stands) v[static_cast<Eigen::Index>(k)] = 0.0;
  }
  std::vector<Place> result;
  geometry::Frames at(robot);
  for (Place& place : at_each_turning_joint(rig)) {
    double moves = 0.0;  // up and down, at a few poses
    for (const double share : {0.2, 0.45, 0.7}) {
      Eigen::VectorXd q(robot.joint_count());
      for (Eigen::Index j = 0; j < q.size(); ++j) {
        const auto& joint = robot.joints[static_cast<std::size_t>(j)];
        q[j] = joint.low + share * (joint.high - joint.low);
      }
      if (!robot.forward_derivative(v, q, rig.robot.assembly, at)) continue;
      for (const auto& by_q : at.by_q) moves += std::abs(by_q(2, place.joint));
    }
    constexpr double kLeast_mm = 1e-6;
    if (!(moves > kLeast_mm)) continue;
    place.other_joint = robot.joint_count() - 1;  // the last one
    result.push_back(std::move(place));
  }
  return result;
}

void bend(
    const Eigen::MatrixXd& weight_m, std::span<const double> x, const Place& place,
    Scene& scene) {
  if (weight_m.rows() <= place.joint) return;
  const double links = carries_links(place) ? x[0] * weight_m(place.joint, 0) : 0.0;
  scene.q[place.joint] += links + x[1] * weight_m(place.joint, 1);
}

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  bend(sample.weight_m, x, place, scene);
}

void bend_sideways(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  bend(sample.weight_sideways_m, x, place, scene);
}

constexpr Effect kSideways{
    .cause = "joint_gravity_sideways",
    .in_words = "weight that pulls sideways",
    .places = places,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .before_kinematics = bend_sideways};

}  // namespace

extern constinit const Effect joint_gravity_compliance;
constinit const Effect joint_gravity_compliance{
    .cause = "joint_gravity_compliance",
    .in_words = "compliance under weight",
    .in_words_with_place = "compliance under weight of {place}",
    .places = places,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kNothing,
    .sham = &kSideways,
    .before_kinematics = bend_kinematics,
    .size = "{links} for the links, {tool} for the tool",
    .plot = {Shows::kJointAngle, Against::kJointAngle, Groups::kNone, false},
    .twin = "joint_gravity_compliance",
    .signature =
        "One joint's angle is off by the moment of the weight that it carries: most with the "
        "arm stretched out level, not at all with it upright.",
    .consequence = "The tool sags, by another amount at every pose and load.",
    .advice =
        "Enter the joint's stiffness and the masses where the controller can make up for sag; "
        "else measure and work with the same load, and keep the arm's reach small.",
    .why_not_learned = "",
    .told_apart =
        "The zero of the encoder takes the mean, an eccentricity what goes by the joint's own "
        "angle; weight also goes by the joints behind. It must explain clearly more than "
        "weight "
        "that pulls sideways, which nothing does.",
    .helps = "The arm stretched and folded at the same angles of that joint; two loads."};

extern constinit const EffectInCode joint_gravity_compliance_in_code;
constinit const EffectInCode joint_gravity_compliance_in_code{
    .cause = "joint_gravity_compliance", .at = [](const Place& place) -> EffectStatements {
      if (!carries_links(place)) return {.joints = "q[{joint}] += {1} * weight[{joint}][1]"};
      return {.joints = "q[{joint}] += {0} * weight[{joint}][0] + {1} * weight[{joint}][1]"};
    }};

const Effect* compliance_under_weight() { return &joint_gravity_compliance; }

}  // namespace sixdial::simulation
