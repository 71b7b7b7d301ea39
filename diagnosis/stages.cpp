#include "diagnosis/stages.h"

#include <array>

namespace sixdial::diagnosis {
namespace {

using simulation::Circumstance;
using simulation::Effect;
using simulation::EffectParameter;
using simulation::Place;
using simulation::Scene;

constexpr std::array kTurn{EffectParameter{"turn", "rad", 1e-2}};
constexpr std::array kShift{EffectParameter{"x", "mm", 1e-2}, EffectParameter{"y", "mm", 1e-2}};
constexpr std::array kShiftInSpace{
    EffectParameter{"x", "mm", 1e-2}, EffectParameter{"y", "mm", 1e-2},
    EffectParameter{"z", "mm", 1e-2}};
constexpr std::array kGrowth{EffectParameter{"growth", "mm", 2e-2}};

// Effects without a name: they are not in the catalogue, since as causes they could not be told
// from the robot's own parameters.
constexpr Effect kAtJoint{
    .parameters = kTurn,
    .before_kinematics = [](std::span<const double> x, const Place& place, const Circumstance&,
                            Scene& scene) { scene.q[place.joint] += x[0]; }};
constexpr Effect kAtTool{
    .parameters = kShift,
    .after_kinematics = [](std::span<const double> x, const Place&, const Circumstance&,
                           Scene& scene) { scene.p_WE += Eigen::Vector3d(x[0], x[1], 0.0); }};
constexpr Effect kAtToolInSpace{
    .parameters = kShiftInSpace,
    .after_kinematics = [](std::span<const double> x, const Place&, const Circumstance&,
                           Scene& scene) { scene.p_WE += Eigen::Vector3d(x[0], x[1], x[2]); }};
constexpr Effect kAtCuboidAngle{
    .parameters = kTurn,
    .before_contact = [](std::span<const double> x, const Place&, const Circumstance&,
                         Scene& scene) { scene.gamma_rad += x[0]; }};
constexpr Effect kAtCuboidSide{
    .parameters = kGrowth,
    .before_contact = [](std::span<const double> x, const Place&, const Circumstance&,
                         Scene& scene) { scene.side_mm += x[0]; }};

const Effect& effect_at(Stage stage, Eigen::Index axes) {
  switch (stage) {
    case Stage::kJointAngle:
      return kAtJoint;
    case Stage::kTool:
      return axes == 3 ? kAtToolInSpace : kAtTool;
    case Stage::kCuboidAngle:
      return kAtCuboidAngle;
    case Stage::kCuboidSide:
      return kAtCuboidSide;
  }
  return kAtTool;
}

}  // namespace

Eigen::MatrixXd stage_columns(
    const Readings& readings, const simulation::ModelVector& at,
    const simulation::ExtendedModel& extended, const Eigen::VectorXd& simulated_mm, Stage stage,
    int joint) {
  const Effect& effect = effect_at(stage, readings.axes());
  const simulation::ActiveEffect none{
      &effect, Place{.joint = joint}, std::vector<double>(effect.parameters.size(), 0.0)};
  return effect_columns(readings, at, extended, none, simulated_mm);
}

}  // namespace sixdial::diagnosis
