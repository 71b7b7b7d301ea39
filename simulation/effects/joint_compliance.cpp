// The joints give under the plungers' springs: theta += K^-1 tau. The torque is the virtual
// work of the plungers (extended_model.h), so that a force beside the elbow turns the link that
// carries the cuboid as well.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"1/K1", "rad/(N mm)", 1e-6, true},
    {"1/K2", "rad/(N mm)", 1e-6, true},
};

void bend_kinematics(
    std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  for (Eigen::Index joint = 0; joint < scene.torque_Nmm.size(); ++joint) {
    scene.q[joint] += x[static_cast<std::size_t>(joint)] * scene.torque_Nmm[joint];
  }
}

}  // namespace

extern constinit const Effect joint_compliance;
constinit const Effect joint_compliance{
    .cause = "joint_compliance",
    .in_words = "compliance",
    .in_words_with_place = "compliance of {place}",
    .places = [](const geometry::Rig& rig) { return on_the_cuboid(rig, "joints"); },
    .parameters = kParameters,
    .needs = kDials,
    .before_kinematics = bend_kinematics,
    .size = "joint 1 {1/K1}, joint 2 {1/K2}",
    .plot = {Shows::kToolShift, Against::kForce, Groups::kNone, false},
    .twin = "joint_compliance",
    .signature =
        "Residuals follow the sum of the plungers' forces, seen through the arm's lever.",
    .consequence = "The tool gives way under load: cutting or probing forces move it.",
    .advice =
        "Stiffen the joints or the drives' control loop; use dials with a lighter spring, or "
        "enter the stiffness.",
    .why_not_learned = "",
    .told_apart =
        "The forces change with which dials touch and how far; effects of the joint angle "
        "alone do not.",
    .helps =
        "The same joint angles with a light and with a heavy load, or other dials in contact."};

}  // namespace sixdial::simulation
