// A dial sits further along its axis than the rig file says.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"shift", "mm", 3e-2},
};

void bend_contact(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  geometry::DialGeometry& dial = scene.dials[static_cast<std::size_t>(place.dial)];
  dial.position_mm += x[0] * dial.axis;
}

}  // namespace

extern constinit const Effect dial_mount;
constinit const Effect dial_mount{
    .cause = "dial_mount",
    .in_words = "mounting position of a dial",
    .in_words_with_place = "mounting position of {place}",
    .places = at_each_dial,
    .parameters = kParameters,
    .needs = kDials,
    .of_rig_geometry = true,
    .before_contact = bend_contact,
    .size = "{shift}",
    .plot = {Shows::kReading, Against::kReading},
    .twin = "dial_mount",
    .signature = "One dial is off by a constant that the others do not share.",
    .consequence = "None on parts; positions that use this dial are shifted.",
    .advice = "Set the dial's zero again on the reference, or enter its position.",
    .why_not_learned = "",
    .told_apart =
        "A wrong cuboid shifts the dials of both faces; a step begins in the middle of a "
        "session.",
    .helps =
        "Four or more dials in contact at once, so that one can be held against the others."};

}  // namespace sixdial::simulation
