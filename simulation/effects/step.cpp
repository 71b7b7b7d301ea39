// Something was knocked: a constant shift from one sample on. The sample is searched.
#include "simulation/effect.h"
#include "simulation/effect_in_code.h"

namespace sixdial::simulation {
namespace {

constexpr EffectParameter kParameters[] = {
    {"shift", "mm or rad", 1e-2}, {"shift_y", "mm", 1e-2}, {"sample", "1", 1.0}};
constexpr int kSample = 2;

std::vector<Place> places(const geometry::Rig& rig) {
  std::vector<Place> result = on_the_cuboid(rig, "base");
  for (const Place& joint : at_each_joint(rig)) result.push_back(joint);
  for (const Place& cuboid : on_the_cuboid(rig, "cuboid")) result.push_back(cuboid);
  for (const Place& dial : at_each_dial(rig)) result.push_back(dial);
  return result;
}

std::optional<EffectParameter> parameter_of_place(const Place& place, int k) {
  constexpr double kLever_mm = 60.0;  // turns a shift of the tool into an angle of that size
  const EffectParameter& parameter = kParameters[k];
  if (k == kSample) return parameter;
  const bool both_axes = place.name == "base";
  if (k == 1 && !both_axes) return std::nullopt;
  const bool turns = (place.joint >= 0 && !place.slides) || place.name == "cuboid";
  if (turns) return EffectParameter{parameter.name, "rad", parameter.sigma / kLever_mm};
  return EffectParameter{parameter.name, "mm", parameter.sigma};
}

SignaturePlot plot(const Place& place) {
  const Shows shows = place.joint >= 0       ? Shows::kJointAngle
                      : place.name == "base" ? Shows::kToolShift
                                             : Shows::kReading;
  return {shows, Against::kTime};
}

bool after(std::span<const double> x, const Circumstance& sample) {
  return sample.order >= x[kSample];
}

void bend_kinematics(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  if (place.joint >= 0 && after(x, sample)) scene.q[place.joint] += x[0];
}

void bend_after_kinematics(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  if (place.name == "base" && after(x, sample)) scene.p_WE += Eigen::Vector3d(x[0], x[1], 0.0);
}

void bend_contact(
    std::span<const double> x, const Place& place, const Circumstance& sample, Scene& scene) {
  if (!after(x, sample)) return;
  if (place.name == "cuboid") scene.gamma_rad += x[0];
  if (place.dial >= 0) {
    geometry::DialGeometry& dial = scene.dials[static_cast<std::size_t>(place.dial)];
    dial.position_mm += x[0] * dial.axis;
  }
}

}  // namespace

extern constinit const Effect step;
constinit const Effect step{
    .cause = "step",
    .in_words = "a step",
    .in_words_with_place = "a step of {place}",
    .places = places,
    .parameters = kParameters,
    .parameter_of_place = parameter_of_place,
    .needs = kNothing,
    .searched = samples_of_a_step,
    .in_time = true,
    .is_step = true,
    .before_kinematics = bend_kinematics,
    .after_kinematics = bend_after_kinematics,
    .before_contact = bend_contact,
    .size = "{shift,shift_y} from sample {=sample} on",
    .plot_of_place = plot,
    .twin = "step",
    .signature = "Residuals jump at one sample and stay there.",
    .consequence = "Parts before and after the event do not fit each other.",
    .advice = "Find what was knocked at that time, fix it, and measure again from there on.",
    .why_not_learned =
        "A network on joint angles cannot learn this: the same angles come with different "
        "errors "
        "before and after the event.",
    .told_apart = "Drift goes on all the time; a step is there from one sample on.",
    .helps =
        "Anchor points measured again before and after the event, at more than one place."};

extern constinit const EffectInCode step_in_code;
constinit const EffectInCode step_in_code{
    .cause = "step", .at = [](const Place& place) -> EffectStatements {
      if (place.joint >= 0) return {.joints = "q[{joint}] += {0}"};
      if (place.name == "base") return {.tool = "p[0] += {0}\np[1] += {1}"};
      return {};  // the cuboid, a dial: the readings alone
    }};

}  // namespace sixdial::simulation
