// The cuboid's centre is not at the tool point.
#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"u", "mm", 5e-2},
    {"v", "mm", 5e-2},
};

void bend_contact(std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  scene.centre_offset_mm += Eigen::Vector2d(x[0], x[1]);
}

}  // namespace

extern constinit const Effect cuboid_offset;
constinit const Effect cuboid_offset{
    .cause = "cuboid_offset",
    .in_words = "offset of the cuboid",
    .places = [](const geometry::Rig& rig) { return on_the_cuboid(rig, "cuboid"); },
    .parameters = kParameters,
    .needs = kDials,
    .of_rig_geometry = true,
    .before_contact = bend_contact,
    .size = "{u,v}",
    .plot = {Shows::kReading, Against::kRotation, Groups::kNone, false},
    .twin = "cuboid_offset",
    .signature = "The residual turns with the cuboid.",
    .consequence = "The tool point that was calibrated is not the one that works.",
    .advice =
        "Centre the cuboid on the tool axis or measure the offset by turning the cuboid by 90 "
        "degrees.",
    .why_not_learned = "",
    .told_apart =
        "Encoder offset and link l22 take up most of it, since the cuboid turns with that "
        "link; only what is left of it counts.",
    .helps =
        "Several working modes, where the same place is measured with the cuboid turned "
        "otherwise."};

}  // namespace sixdial::simulation
