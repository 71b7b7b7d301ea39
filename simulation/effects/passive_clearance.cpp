// Play in the passive elbow joints: E lags or leads along its direction of travel.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"c", "mm", 8e-3},
};

void bend_after_kinematics(
    std::span<const double> x, const Place&, const Circumstance& sample, Scene& scene) {
  scene.p_WE += x[0] * sample.travel;
}

std::vector<Place> places(const geometry::Rig& rig) {
  if (!rig.robot.model->kind->has_passive_joints) return {};
  return at_one_place(rig, "elbows");
}

}  // namespace

extern constinit const Effect passive_clearance;
constinit const Effect passive_clearance{
    .cause = "passive_clearance",
    .in_words = "clearance of the elbow joints",
    .places = places,
    .parameters = kParameters,
    .needs = kNothing,
    .after_kinematics = bend_after_kinematics,
    .size = "{c}",
    .plot = {Shows::kToolShift, Against::kTravel},
    .twin = "passive_clearance",
    .signature = "Residuals point along the last move of the tool.",
    .consequence = "A part depends on the direction from which each position was approached.",
    .advice = "Replace or preload the elbow bearings, or always approach from the same side.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with different "
        "errors, by the direction of the last move.",
    .told_apart =
        "Backlash goes by the direction of one joint; clearance by the direction of the "
        "tool's last move.",
    .helps = "The same places reached from four directions."};

extern constinit const EffectInCode passive_clearance_in_code;
constinit const EffectInCode passive_clearance_in_code{
    .cause = "passive_clearance", .at = [](const Place&) -> EffectStatements {
      return {.tool = "p[{axis}] += {0} * travel[{axis}]"};
    }};

}  // namespace sixdial::simulation
