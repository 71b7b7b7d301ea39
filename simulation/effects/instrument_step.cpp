// The instrument, or the robot's base, was knocked: its frame is another from one sample on.
// Turns count in millimetres at a metre's distance, so that all numbers are of one size.
#include <Eigen/Geometry>

#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"x", "mm", 5e-2},    {"y", "mm", 5e-2},    {"z", "mm", 5e-2},   {"rx", "mm/m", 5e-2},
    {"ry", "mm/m", 5e-2}, {"rz", "mm/m", 5e-2}, {"sample", "1", 1.0}};
constexpr int kSample = 6;

/// In the plane: two shifts and the turn about z.
std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  const bool in_plane = k == 0 || k == 1 || k == 5 || k == kSample;
  if (place.axes < 3 && !in_plane) return std::nullopt;
  return kParameters[k];
}

void bend_after_kinematics(
    std::span<const double> x, const Place&, const Circumstance& sample, Scene& scene) {
  if (sample.order < x[kSample]) return;
  constexpr double kMetre_mm = 1000.0;
  const Eigen::Vector3d turn_rad = Eigen::Vector3d(x[3], x[4], x[5]) / kMetre_mm;
  scene.p_WE += Eigen::Vector3d(x[0], x[1], x[2]) + turn_rad.cross(scene.p_WE);
  scene.turn_rad += turn_rad;
}

}  // namespace

extern constinit const Effect instrument_step;
constinit const Effect instrument_step{
    .cause = "instrument_step",
    .in_words = "a knock of the instrument",
    .places = at_the_instrument,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kNothing,
    .searched = samples_of_a_step,
    .in_time = true,
    .is_step = true,
    .after_kinematics = bend_after_kinematics,
    .size = "{x,y,z}, turned by {rx,ry,rz}, from sample {=sample} on",
    .plot = {Shows::kToolShift, Against::kTime},
    .twin = "instrument_step",
    .signature =
        "All residuals jump at one sample, as if the whole robot had moved, and stay there.",
    .consequence = "Rows before and after the event do not belong to one frame.",
    .advice =
        "Find what was knocked at that time, fix it, and measure again from there on; or treat "
        "the two parts as two sessions.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with different "
        "errors before and after the event.",
    .told_apart = "Drift goes on all the time; a knock is there from one sample on.",
    .helps = "A few poses measured again before and after the event."};

extern constinit const EffectInCode instrument_step_in_code;
constinit const EffectInCode instrument_step_in_code{
    .cause = "instrument_step", .at = [](const Place&) -> EffectStatements {
      return {
          .tool =
              "p[0] += {0} + ({4} * was[2] - {5} * was[1]) / 1000.0\n"
              "p[1] += {1} + ({5} * was[0] - {3} * was[2]) / 1000.0\n"
              "p[2] += {2} + ({3} * was[1] - {4} * was[0]) / 1000.0\n"
              "turn[0] += {3} / 1000.0\n"
              "turn[1] += {4} / 1000.0\n"
              "turn[2] += {5} / 1000.0"};
    }};

}  // namespace sixdial::simulation
