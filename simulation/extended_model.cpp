#include "simulation/extended_model.h"

#include <algorithm>
#include <cmath>
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

/// Heading of a frame in W [rad].
double turn_of(const geometry::Frames& at, int frame) {
  const auto& R = at.X[static_cast<std::size_t>(frame)].R;
  return std::atan2(R(1, 0), R(0, 0));
}

}  // namespace

ExtendedModel::ExtendedModel(const ForwardModel& base, std::vector<ActiveEffect> effects)
    : base_(&base), effects_(std::move(effects)) {}

bool ExtendedModel::needs_torque(const ActiveEffect* extra) const {
  const auto bends_joints = [](const ActiveEffect& active) {
    return active.effect->needs & kDials && active.effect->before_kinematics;
  };
  return (extra && bends_joints(*extra)) || std::ranges::any_of(effects_, bends_joints);
}

ExtendedModel::Torque ExtendedModel::torque_Nmm(
    const ModelVector& model, const Trial& trial, const Circumstance& sample) const {
  const auto& rig = base_->rig();
  geometry::Frames at(base_->robot());
  const auto reached = base_->robot().forward_derivative(
      model.head(base_->robot_parameter_count()), trial.q, trial.assembly, at);
  if (!reached) return tl::unexpected(reached.error());
  const std::optional<int> link = base_->cuboid_link();
  const geometry::CuboidPose cuboid{
      at.X[0].p.head<2>(), cuboid_angle(model, trial, link ? turn_of(at, *link) : 0.0)};
  Eigen::Matrix3Xd by_q = Eigen::Matrix3Xd::Zero(3, trial.q.size());  // of x, y, gamma
  by_q.topRows<2>() = at.by_q[0].topRows<2>();
  if (link) by_q.bottomRows<1>() = at.by_q[static_cast<std::size_t>(*link)].bottomRows<1>();
  Eigen::VectorXd torque_Nmm = Eigen::VectorXd::Zero(trial.q.size());
  for (std::size_t i = 0; i < sample.plunger_force_n.size(); ++i) {
    if (sample.plunger_force_n[i] == 0.0) continue;
    const geometry::DialGeometry& dial = rig.dials[i].geometry;
    const geometry::Contact contact = geometry::contact_on_face(
        dial, cuboid, rig.cuboid.side_mm, geometry::face_towards(dial, cuboid.gamma_rad));
    torque_Nmm -= sample.plunger_force_n[i] * (contact.J * by_q).transpose();
  }
  return torque_Nmm;
}

void ExtendedModel::bend_joints(
    const Circumstance& sample, Scene& scene, const ActiveEffect* extra) const {
  apply(&Effect::before_kinematics, effects_, extra, sample, scene);
}

double ExtendedModel::cuboid_angle(
    const ModelVector& model, const Trial& trial, double link_rad) const {
  const auto& rig = base_->rig();
  if (rig.cuboid.mount == geometry::Mount::kFree && trial.gamma_rad) return *trial.gamma_rad;
  // An instrument without a cuboid has no clamp angle.
  const Eigen::Index clamp = base_->robot_parameter_count();
  return geometry::cuboid_angle(
      rig, base_->reference_angle_rad(), link_rad, model.size() > clamp ? model[clamp] : 0.0);
}

void ExtendedModel::measure(
    const Circumstance& sample, Scene& scene, const ActiveEffect* extra) const {
  const auto& rig = base_->rig();
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
}

tl::expected<void, geometry::KinematicTrouble> ExtendedModel::run(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
    const ActiveEffect* extra) const {
  if (needs_torque(extra)) {
    auto torque = torque_Nmm(model, trial, sample);
    if (!torque) return tl::unexpected(torque.error());
    scene.torque_Nmm = std::move(*torque);
  }
  scene.q = trial.q;
  scene.v = model.head(base_->robot_parameter_count());
  bend_joints(sample, scene, extra);
  const auto pose = geometry::planar_pose(
      base_->robot(), scene.v, scene.q, trial.assembly, base_->cuboid_link());
  if (!pose) return tl::unexpected(pose.error());
  scene.p_WE = pose->p_WE;
  scene.gamma_rad = cuboid_angle(model, trial, pose->link_rad);
  measure(sample, scene, extra);
  return {};
}

}  // namespace sixdial::simulation
