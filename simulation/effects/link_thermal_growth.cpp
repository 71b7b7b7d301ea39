// Links grow with temperature: l (1 + a (T - 20 degC)), ISO 1 reference temperature. In space
// the whole robot between its base and its tool does: not every length is a parameter there.
#include <algorithm>

#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"a", "1/K", 2e-5},
};

double grown(std::span<const double> x, const Circumstance& sample) {
  constexpr double kReference_degC = 20.0;
  return x[0] * (sample.temperature_degC - kReference_degC);
}

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  if (place.axes > 2) return;
  for (const int k : scene.growing) scene.v[k] *= 1.0 + grown(x, sample);
}

void bend_after_kinematics(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  if (place.axes < 3) return;
  scene.p_WE += grown(x, sample) * (scene.end_mm - scene.stands_mm);
}

std::vector<Place> places(const geometry::Rig& rig) {
  const auto& parameters = rig.robot.model->parameters;
  if (std::ranges::none_of(parameters, &geometry::ParameterInfo::grows)) return {};
  return at_one_place(rig, "links");
}

}  // namespace

extern constinit const Effect link_thermal_growth;
constinit const Effect link_thermal_growth{
    .cause = "link_thermal_growth",
    .in_words = "thermal growth of the links",
    .places = places,
    .parameters = kParameters,
    .needs = kTemperature,
    .before_kinematics = bend_kinematics,
    .after_kinematics = bend_after_kinematics,
    .size = "{a}",
    .plot = {Shows::kToolShift, Against::kTemperature, Groups::kNone, false},
    .twin = "link_thermal_growth",
    .signature = "Residuals point outwards along the arm and grow with temperature.",
    .consequence = "Parts grow or shift as the machine warms up.",
    .advice =
        "Let the machine warm up before measuring and working, keep the room steady, or enter "
        "the expansion coefficient.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with different "
        "errors at different temperatures.",
    .told_apart =
        "Drift of the base goes with the clock; with a temperature that only rises the two "
        "look alike.",
    .helps = "A temperature that goes up and down again, with anchor points revisited."};

extern constinit const EffectInCode link_thermal_growth_in_code;
constinit const EffectInCode link_thermal_growth_in_code{
    .cause = "link_thermal_growth", .at = [](const Place& place) -> EffectStatements {
      if (place.axes < 3) {
        return {.joints = "v[{grows}] *= 1.0 + {0} * (temperature_degC - 20.0)"};
      }
      return {
          .tool =
              "p[{axis}] += {0} * (temperature_degC - 20.0) * (end[{axis}] - stands[{axis}])"};
    }};

}  // namespace sixdial::simulation
