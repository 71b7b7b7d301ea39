// What measures the tool creeps while time passes: its frame shifts and turns. Turns count in
// millimetres at a metre's distance, so that all numbers are of one size.
#include <Eigen/Geometry>

#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"vx", "mm/h", 5e-2},     {"vy", "mm/h", 5e-2},     {"vz", "mm/h", 5e-2},
    {"wx", "mm/(m h)", 5e-2}, {"wy", "mm/(m h)", 5e-2}, {"wz", "mm/(m h)", 5e-2},
};

/// In the plane: two shifts and the turn about z.
std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  const bool in_plane = k == 0 || k == 1 || k == 5;
  if (place.axes < 3 && !in_plane) return std::nullopt;
  return kParameters[k];
}

void bend_after_kinematics(
    std::span<const double> x, const Place&, const Circumstance& sample, Scene& scene) {
  constexpr double kMetre_mm = 1000.0;
  const Eigen::Vector3d turn_rad =
      sample.time_h / kMetre_mm * Eigen::Vector3d(x[3], x[4], x[5]);
  scene.p_WE += sample.time_h * Eigen::Vector3d(x[0], x[1], x[2]) + turn_rad.cross(scene.p_WE);
  scene.turn_rad += turn_rad;
}

}  // namespace

extern constinit const Effect instrument_drift;
constinit const Effect instrument_drift{
    .cause = "instrument_drift",
    .in_words = "drift of the instrument",
    .places = at_the_instrument,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kTime,
    .in_time = true,
    .after_kinematics = bend_after_kinematics,
    .size = "{vx,vy,vz}, turning {wx,wy,wz}",
    .plot = {Shows::kToolShift, Against::kTime},
    .twin = "instrument_drift",
    .signature =
        "All residuals move steadily together, as if the whole robot went past the "
        "instrument, from the first sample to the last.",
    .consequence =
        "None on parts if the instrument moved; if the robot's base did, parts made later are "
        "shifted against parts made earlier.",
    .advice =
        "Check the feet of the instrument and of the robot; measure a few fixed points on the "
        "table before, during and after a session.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with different "
        "errors at different times.",
    .told_apart =
        "A knock jumps at one sample, drift goes on all the time. Whether the instrument or "
        "the robot's base moves only points on the table can tell.",
    .helps = "A few poses measured again at the start, in the middle and at the end."};

extern constinit const EffectInCode instrument_drift_in_code;
constinit const EffectInCode instrument_drift_in_code{
    .cause = "instrument_drift", .at = [](const Place&) -> EffectStatements {
      return {
          .tool =
              "p[0] += time_h * ({0} + ({4} * was[2] - {5} * was[1]) / 1000.0)\n"
              "p[1] += time_h * ({1} + ({5} * was[0] - {3} * was[2]) / 1000.0)\n"
              "p[2] += time_h * ({2} + ({3} * was[1] - {4} * was[0]) / 1000.0)\n"
              "turn[0] += time_h * {3} / 1000.0\n"
              "turn[1] += time_h * {4} / 1000.0\n"
              "turn[2] += time_h * {5} / 1000.0"};
    }};

}  // namespace sixdial::simulation
