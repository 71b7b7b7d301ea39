// The base creeps on the table while time passes: x0 and y0 grow.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"vx", "mm/h", 5e-2},
    {"vy", "mm/h", 5e-2},
};

void bend_after_kinematics(
    std::span<const double> x, const Place&, const Circumstance& sample, Scene& scene) {
  scene.p_WE.x() += x[0] * sample.time_h;
  scene.p_WE.y() += x[1] * sample.time_h;
}

}  // namespace

extern constinit const Effect base_drift;
constinit const Effect base_drift{
    .cause = "base_drift",
    .in_words = "drift of the base",
    .places = [](const geometry::Rig& rig) { return on_the_cuboid(rig, "base"); },
    .parameters = kParameters,
    .needs = kTime,
    .in_time = true,
    .after_kinematics = bend_after_kinematics,
    .size = "{vx,vy}",
    .plot = {Shows::kToolShift, Against::kTime},
    .twin = "base_drift",
    .signature =
        "All residuals move steadily in one direction of the table from the first sample to "
        "the last.",
    .consequence = "Parts made later are shifted against parts made earlier.",
    .advice =
        "Check the base's bolts and the table's temperature; re-measure a few anchor points "
        "between parts.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with different "
        "errors at different times.",
    .told_apart =
        "A step jumps at one sample, drift goes on all the time; thermal growth follows "
        "temperature, not the clock.",
    .helps =
        "A few anchor points measured again at the start, in the middle and at the end; a "
        "temperature that does not rise with the clock."};

extern constinit const EffectInCode base_drift_in_code;
constinit const EffectInCode base_drift_in_code{
    .cause = "base_drift", .at = [](const Place&) -> EffectStatements {
      return {
          .tool =
              "p[0] += {0} * time_h\n"
              "p[1] += {1} * time_h"};
    }};

}  // namespace sixdial::simulation
