// The cuboid is not as long as the rig file says.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"l", "mm", 2e-2},
};

void bend_contact(std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  scene.side_mm += x[0];
}

}  // namespace

extern constinit const Effect cuboid_size;
constinit const Effect cuboid_size{
    .cause = "cuboid_size",
    .in_words = "size of the cuboid",
    .places = [](const geometry::Rig& rig) { return on_the_cuboid(rig, "cuboid"); },
    .parameters = kParameters,
    .needs = kDials,
    .of_rig_geometry = true,
    .before_contact = bend_contact,
    .size = "{l}",
    .plot = {Shows::kReading, Against::kRotation},
    .twin = "cuboid_size",
    .signature =
        "Dials on opposite faces are off to the same side of their scale by equal amounts.",
    .consequence = "None on parts; positions from one face and from its opposite disagree.",
    .advice = "Measure the cuboid with a micrometer and enter side_mm.",
    .why_not_learned = "",
    .told_apart =
        "A wrong dial position moves one dial alone; a wrong tip radius grows with rotation, "
        "a wrong size does not.",
    .helps = "Samples with dials on opposite faces in contact at once."};

}  // namespace sixdial::simulation
