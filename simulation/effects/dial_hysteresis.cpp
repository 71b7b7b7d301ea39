// A dial reads differently by the direction of its plunger's last move.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"h", "mm", 4e-3},
};

void bend_after_reading(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  const auto dial = static_cast<std::size_t>(place.dial);
  scene.reading[dial] -= 0.5 * x[0] * sample.plunger_direction[dial];
}

}  // namespace

extern constinit const Effect dial_hysteresis;
constinit const Effect dial_hysteresis{
    .cause = "dial_hysteresis",
    .in_words = "hysteresis of a dial",
    .in_words_with_place = "hysteresis of {place}",
    .places = at_each_dial,
    .parameters = kParameters,
    .needs = kDials,
    .within_accuracy = true,
    .after_reading = bend_after_reading,
    .size = "{h}",
    .plot = {Shows::kReading, Against::kReading, Groups::kPlungerDirection},
    .twin = "dial_hysteresis",
    .signature = "One dial's residual has two levels: plunger going in, plunger coming out.",
    .consequence =
        "None on parts; this dial's readings depend on the direction of the last move.",
    .advice =
        "Clean or replace the dial's plunger guide, or always approach from the same side.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with two different "
        "readings.",
    .told_apart =
        "Backlash shows on all dials and by the direction of the joint; this shows on one "
        "dial and by the direction of its own plunger.",
    .helps = "Each place approached with the plunger going in and coming out."};

}  // namespace sixdial::simulation
