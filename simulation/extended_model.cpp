#include "simulation/extended_model.h"

#include <cmath>
#include <limits>
#include <utility>

#include "geometry/tool.h"

namespace sixdial::simulation {
namespace {

void apply(
    Effect::Hook Effect::*hook, const std::vector<ActiveEffect>& effects,
    const ActiveEffect* extra, const Circumstance& sample, Scene& scene) {
  for (const ActiveEffect& active : effects) {
    if (active.effect->*hook) (active.effect->*hook)(active.x, active.place, sample, scene);
  }
  if (extra && extra->effect->*hook) {
    (extra->effect->*hook)(extra->x, extra->place, sample, scene);
  }
}

double sign(double value) { return value > 0 ? 1.0 : value < 0 ? -1.0 : 0.0; }

}  // namespace

std::vector<Circumstance> circumstances_of(
    const ForwardModel& model, const ModelVector& at, std::span<const Trial> trials) {
  const auto& rig = model.rig();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Circumstance> result;
  std::vector<double> previous(rig.dials.size(), nan);
  std::vector<double> rest(
      rig.dials.size(), 0.0);  // where the plunger stood one sample earlier
  std::optional<Eigen::Vector2d> last_position;
  double first_s = trials.empty() ? 0.0 : trials.front().time_s.value_or(0.0);
  for (const Trial& trial : trials) {
    Circumstance each;
    each.order = static_cast<int>(result.size());
    each.time_h = (trial.time_s.value_or(first_s) - first_s) / 3600.0;
    each.temperature_degC = trial.temperature_c.value_or(20.0);
    each.approach.resize(trial.q.size());
    for (Eigen::Index joint = 0; joint < trial.q.size(); ++joint) {
      each.approach[joint] = trial.approach_of(static_cast<std::size_t>(joint));
    }
    const auto pose = geometry::planar_pose(
        model.robot(), at.head(model.robot_parameter_count()), trial.q, trial.assembly,
        std::nullopt);
    if (pose) {
      if (last_position) {
        const Eigen::Vector2d move = pose->p_WE - *last_position;
        if (move.norm() > 1e-9) each.travel = move.normalized();
      }
      last_position = pose->p_WE;
    }
    each.previous_mm = previous;
    each.plunger_direction.assign(rig.dials.size(), 0.0);
    for (std::size_t i = 0; i < rig.dials.size() && i < trial.reading.size(); ++i) {
      const auto& reading = trial.reading[i];
      const double now = reading.value_or(0.0);
      if (!result.empty()) each.plunger_direction[i] = sign(now - rest[i]);
      if (reading) {
        const auto& dial = rig.dials[i];
        each.force_n += (dial.force_n + dial.spring_n_per_mm * now) * dial.geometry.axis;
      }
      previous[i] = reading.value_or(nan);
      rest[i] = now;
    }
    result.push_back(std::move(each));
  }
  return result;
}

ExtendedModel::ExtendedModel(const ForwardModel& base, std::vector<ActiveEffect> effects)
    : base_(&base), effects_(std::move(effects)) {}

tl::expected<void, geometry::KinematicTrouble> ExtendedModel::run(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
    const ActiveEffect* extra) const {
  const auto& rig = base_->rig();
  scene.q = trial.q;
  const Eigen::Index robot_parameters = base_->robot_parameter_count();
  scene.v = model.head(robot_parameters);
  const auto bends_joints = [](const ActiveEffect& active) {
    return active.effect->needs & kDials && active.effect->before_kinematics;
  };
  bool needs_J = extra && bends_joints(*extra);
  for (const ActiveEffect& active : effects_) needs_J = needs_J || bends_joints(active);
  if (needs_J) {
    const auto rigid = geometry::planar_pose(
        base_->robot(), scene.v, scene.q, trial.assembly, std::nullopt, &scene.J_q);
    if (!rigid) return tl::unexpected(rigid.error());
  }
  apply(&Effect::before_kinematics, effects_, extra, sample, scene);

  const auto pose = geometry::planar_pose(
      base_->robot(), scene.v, scene.q, trial.assembly, base_->cuboid_link());
  if (!pose) return tl::unexpected(pose.error());
  scene.p_WE = pose->p_WE;
  // An instrument without a cuboid has no clamp angle.
  const double clamp_rad = model.size() > robot_parameters ? model[robot_parameters] : 0.0;
  scene.gamma_rad =
      geometry::cuboid_angle(rig, base_->reference_angle_rad(), pose->link_rad, clamp_rad);
  if (rig.cuboid.mount == geometry::Mount::kFree && trial.gamma_rad) {
    scene.gamma_rad = *trial.gamma_rad;
  }
  apply(&Effect::after_kinematics, effects_, extra, sample, scene);

  scene.side_mm = rig.cuboid.side_mm;
  scene.squareness_rad = 0.0;
  scene.centre_offset_mm.setZero();
  scene.dials.resize(rig.dials.size());
  for (std::size_t i = 0; i < rig.dials.size(); ++i) scene.dials[i] = rig.dials[i].geometry;
  apply(&Effect::before_contact, effects_, extra, sample, scene);

  const Eigen::Vector2d heading(std::cos(scene.gamma_rad), std::sin(scene.gamma_rad));
  const Eigen::Vector2d across(-heading.y(), heading.x());
  const double turn = scene.squareness_rad;
  const Eigen::Vector2d turned =
      turn == 0.0
          ? heading
          : Eigen::Vector2d(std::cos(scene.gamma_rad + turn), std::sin(scene.gamma_rad + turn));
  const Eigen::Vector2d centre =
      scene.p_WE + scene.centre_offset_mm.x() * heading + scene.centre_offset_mm.y() * across;
  scene.reading_mm.resize(rig.dials.size());
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    const int face = geometry::face_towards(rig.dials[i].geometry, heading);
    scene.reading_mm[i] = geometry::displacement_on_face(
        scene.dials[i], centre, scene.side_mm,
        geometry::face_normal(face, face % 2 != 0 ? turned : heading));
  }
  apply(&Effect::after_reading, effects_, extra, sample, scene);
  return {};
}

}  // namespace sixdial::simulation
