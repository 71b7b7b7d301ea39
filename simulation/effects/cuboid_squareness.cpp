// Neighbouring faces of the cuboid are not at a right angle.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"s", "rad", 3e-4},
};

void bend_contact(std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  scene.squareness_rad += x[0];
}

}  // namespace

extern constinit const Effect cuboid_squareness;
constinit const Effect cuboid_squareness{
    .cause = "cuboid_squareness",
    .in_words = "squareness of the cuboid",
    .places = [](const geometry::Rig& rig) { return on_the_cuboid(rig, "cuboid"); },
    .parameters = kParameters,
    .needs = kDials,
    .of_rig_geometry = true,
    .before_contact = bend_contact,
    .size = "{s}",
    .plot = {Shows::kReading, Against::kRotation, Groups::kNone, false},
    .twin = "cuboid_squareness",
    .signature =
        "Dials of one pair of faces are off in proportion to their distance from the middle of "
        "the face.",
    .consequence = "None on parts; measured x and y are not independent.",
    .advice = "Measure the cuboid's squareness, enter it or use a better cuboid.",
    .why_not_learned = "",
    .told_apart =
        "Skew of the frame acts wherever the cuboid stands; squareness acts by the distance "
        "from the middle of the face and turns with it.",
    .helps = "Large rotation of the cuboid and two dials of one face in contact."};

}  // namespace sixdial::simulation
