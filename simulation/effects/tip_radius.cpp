// The dials' balls have another radius than the rig file says.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"rho", "mm", 3e-2},
};

void bend_contact(std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  for (geometry::DialGeometry& dial : scene.dials) {
    // The front of the tip stays where it was set; the ball's centre moves back.
    dial.tip_radius_mm += x[0];
  }
}

}  // namespace

extern constinit const Effect tip_radius;
constinit const Effect tip_radius{
    .cause = "tip_radius",
    .in_words = "radius of the tips",
    .places = [](const geometry::Rig& rig) { return on_the_cuboid(rig, "dials"); },
    .parameters = kParameters,
    .needs = kDials,
    .of_rig_geometry = true,
    .before_contact = bend_contact,
    .size = "{rho}",
    .plot = {Shows::kReading, Against::kRotation, Groups::kNone, false},
    .twin = "tip_radius",
    .signature = "Residuals grow with the cuboid's rotation, alike on all dials.",
    .consequence = "None on parts; positions are wrong where the cuboid is turned.",
    .advice = "Measure a tip and enter tip_radius_mm.",
    .why_not_learned = "",
    .told_apart = "A wrong cuboid size does not depend on rotation; lean belongs to one dial.",
    .helps = "Rotation of the cuboid to both sides, with dials of all faces."};

}  // namespace sixdial::simulation
