// The instrument's lengths are too long or too short by a constant share: p += s p.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"s", "1", 1e-3},
};

/// Contacts and sockets have no lengths of their own that could be wrong; a wire's share would
/// be its own.
std::vector<Place> where_places_are_measured(const geometry::Rig& rig) {
  const bool places = geometry::instrument_of(rig)->find_channel("x").has_value();
  return places ? at_the_instrument(rig) : std::vector<Place>();
}

void bend_after_kinematics(
    std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
  scene.p_WE += x[0] * scene.p_WE;
}

}  // namespace

extern constinit const Effect instrument_scale;
constinit const Effect instrument_scale{
    .cause = "instrument_scale",
    .in_words = "wrong scale of the instrument",
    .places = where_places_are_measured,
    .parameters = kParameters,
    .needs = kNothing,
    .after_kinematics = bend_after_kinematics,
    .size = "{s}",
    .plot = {Shows::kToolShift, Against::kOtherCoordinate, Groups::kNone, false},
    .twin = "instrument_scale",
    .signature = "Residuals point away from one place and grow with the distance from it.",
    .consequence = "Parts come out too large or too small in proportion.",
    .advice =
        "Check the instrument against a length that is known (a scale bar), and its unit, "
        "temperature and air pressure settings.",
    .why_not_learned = "",
    .told_apart =
        "All links of the robot longer by the same share look just so: where every length is "
        "free, nothing can tell them apart.",
    .helps = "A scale bar in the measured volume."};

extern constinit const EffectInCode instrument_scale_in_code;
constinit const EffectInCode instrument_scale_in_code{
    .cause = "instrument_scale", .at = [](const Place&) -> EffectStatements {
      return {.tool = "p[{axis}] += {0} * p[{axis}]"};
    }};

}  // namespace sixdial::simulation
