// A dial's axis is tilted in the plane.
#include <Eigen/Geometry>

#include "simulation/effect.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"angle", "rad", 5e-3},
};

void bend_contact(
    std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  geometry::DialGeometry& dial = scene.dials[static_cast<std::size_t>(place.dial)];
  dial.axis = Eigen::Rotation2Dd(x[0]) * dial.axis;
}

}  // namespace

extern constinit const Effect dial_lean;
constinit const Effect dial_lean{
    .cause = "dial_lean",
    .in_words = "lean of a dial",
    .in_words_with_place = "lean of {place}",
    .places = at_each_dial,
    .parameters = kParameters,
    .needs = kDials,
    .of_rig_geometry = true,
    .before_contact = bend_contact,
    .size = "{angle}",
    .plot = {Shows::kReading, Against::kReadingTimesRotation, Groups::kNone, false},
    .twin = "dial_lean",
    .signature =
        "One dial's residual grows with the product of its reading and the cuboid's rotation.",
    .consequence = "None on parts; positions that use this dial are bent.",
    .advice = "Square the dial's holder, or enter its axis.",
    .why_not_learned = "",
    .told_apart =
        "A wrong scale does not care about rotation; a wrong tip radius bends all dials "
        "alike.",
    .helps = "Large readings of that dial at both signs of the cuboid's rotation."};

}  // namespace sixdial::simulation
