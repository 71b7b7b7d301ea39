// A dial's scale is stretched: reading (1 + g).
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"g", "1", 1e-3},
};

void bend_after_reading(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  double& reading_mm = scene.reading[static_cast<std::size_t>(place.dial)];
  reading_mm *= 1.0 + x[0];
}

}  // namespace

extern constinit const Effect dial_gain;
constinit const Effect dial_gain{
    .cause = "dial_gain",
    .in_words = "scale of a dial",
    .in_words_with_place = "scale of {place}",
    .places = at_each_dial,
    .parameters = kParameters,
    .needs = kDials,
    .after_reading = bend_after_reading,
    .size = "{g}",
    .plot = {Shows::kReading, Against::kReading},
    .twin = "dial_gain",
    .signature = "One dial's residual grows in proportion to its reading.",
    .consequence = "None on parts; positions that use this dial are stretched.",
    .advice = "Check the dial against gauge blocks; repair, or enter its factor.",
    .why_not_learned = "",
    .told_apart =
        "Lean of the dial needs rotation of the cuboid too; a cyclic error comes back to zero "
        "each period.",
    .helps =
        "Readings of that dial over its whole travel, at small and at large rotation of the "
        "cuboid."};

}  // namespace sixdial::simulation
