// The measuring frame's axes are not square: x += s (y - y_ref); in space also x += s_xz z and
// y += s_yz z.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"s", "rad", 3e-4},
    {"s_xz", "rad", 3e-4},
    {"s_yz", "rad", 3e-4},
};

void bend_after_kinematics(
    std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  // About the origin of W; what a rotation takes is left to the robot's alpha.
  scene.p_WE.x() += x[0] * scene.p_WE.y() + x[1] * scene.p_WE.z();
  scene.p_WE.y() += x[2] * scene.p_WE.z();
}

std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  if (k > 0 && place.axes < 3) return std::nullopt;
  return kParameters[k];
}

}  // namespace

extern constinit const Effect frame_skew;
constinit const Effect frame_skew{
    .cause = "frame_skew",
    .in_words = "skew of the measuring frame",
    .places = [](const geometry::Rig& rig) { return at_one_place(rig, "frame"); },
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kNothing,
    .after_kinematics = bend_after_kinematics,
    .size = "{s,s_xz,s_yz}",
    .plot = {Shows::kToolShift, Against::kOtherCoordinate},
    .twin = "frame_skew",
    .signature = "Residuals in x grow with y.",
    .consequence = "Squares come out as rhombs.",
    .advice = "Square the dials' holders against a reference square and enter their axes.",
    .why_not_learned = "",
    .told_apart =
        "The base's rotation and the links take up part of it; squareness of the cuboid turns "
        "with the cuboid, skew does not.",
    .helps = "A large area in x and y, and several working modes."};

extern constinit const EffectInCode frame_skew_in_code;
constinit const EffectInCode frame_skew_in_code{
    .cause = "frame_skew", .at = [](const Place&) -> EffectStatements {
      return {
          .tool =
              "p[0] += {0} * p[1] + {1} * p[2]\n"
              "p[1] += {2} * p[2]"};
    }};

}  // namespace sixdial::simulation
