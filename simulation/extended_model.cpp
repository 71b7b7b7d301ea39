#include "simulation/extended_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/rotation.h"
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
    : base_(&base), effects_(std::move(effects)) {
  const auto& parameters = base.robot().parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k].grows) growing_.push_back(static_cast<int>(k));
    const bool place = parameters[k].stands && parameters[k].unit == "mm";
    if (place && stands_.size() < 3) stands_.push_back(static_cast<int>(k));
  }
}

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
  scene.growing = growing_;
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

void ExtendedModel::move_tool(
    const Circumstance& sample, Scene& scene, const ActiveEffect* extra) const {
  scene.turn_rad.setZero();
  apply(&Effect::after_kinematics, effects_, extra, sample, scene);
}

void ExtendedModel::move_frames(Scene& scene) {
  const Eigen::Matrix3d turned =
      Eigen::Matrix3d::Identity() + geometry::skew<double>(scene.turn_rad);
  const Eigen::Vector3d tool = scene.X[0].p;
  for (geometry::Pose<double>& each : scene.X) {
    each.p = scene.p_WE + turned * (each.p - tool);
    each.R = turned * each.R;
  }
}

void ExtendedModel::read_dials(Scene& scene) const {
  const auto& rig = base_->rig();
  const Eigen::Vector2d heading(std::cos(scene.gamma_rad), std::sin(scene.gamma_rad));
  const Eigen::Vector2d across(-heading.y(), heading.x());
  const double turn = scene.squareness_rad;
  const Eigen::Vector2d turned =
      turn == 0.0
          ? heading
          : Eigen::Vector2d(std::cos(scene.gamma_rad + turn), std::sin(scene.gamma_rad + turn));
  const Eigen::Vector2d centre = scene.p_WE.head<2>() + scene.centre_offset_mm.x() * heading +
                                 scene.centre_offset_mm.y() * across;
  scene.reading.resize(rig.dials.size());
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    const int face = geometry::face_towards(rig.dials[i].geometry, heading);
    scene.reading[i] = geometry::displacement_on_face(
        scene.dials[i], centre, scene.side_mm,
        geometry::face_normal(face, face % 2 != 0 ? turned : heading));
  }
}

void ExtendedModel::read_channels(
    const ModelVector& model, const Trial& trial, Scene& scene) const {
  const geometry::InstrumentModel& instrument = base_->instrument();
  const Eigen::Index of_robot = base_->robot_parameter_count();
  const std::span<const double> x(
      model.data() + of_robot, static_cast<std::size_t>(model.size() - of_robot));
  instrument.kind->observe(instrument, x, {}, scene.X, false, scene.seen);
  const bool whole =
      trial.reading.size() == static_cast<std::size_t>(scene.seen.reading.size());
  if (instrument.kind->nearest && whole) instrument.kind->nearest(trial.reading, scene.seen);
  scene.reading.assign(scene.seen.reading.begin(), scene.seen.reading.end());
}

void ExtendedModel::measure(
    const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
    const ActiveEffect* extra) const {
  move_tool(sample, scene, extra);
  if (base_->rig().on_cuboid()) {
    const auto& rig = base_->rig();
    scene.side_mm = rig.cuboid.side_mm;
    scene.squareness_rad = 0.0;
    scene.centre_offset_mm.setZero();
    scene.dials.resize(rig.dials.size());
    for (std::size_t i = 0; i < rig.dials.size(); ++i) {
      scene.dials[i] = rig.dials[i].geometry;
    }
    apply(&Effect::before_contact, effects_, extra, sample, scene);
    read_dials(scene);
  } else {
    move_frames(scene);
    read_channels(model, trial, scene);
  }
  apply(&Effect::after_reading, effects_, extra, sample, scene);
}

void ExtendedModel::set_ends(Scene& scene) const {
  for (std::size_t axis = 0; axis < stands_.size(); ++axis) {
    scene.stands_mm[static_cast<Eigen::Index>(axis)] = scene.v[stands_[axis]];
  }
  const bool chain = !base_->robot().kind->has_passive_joints;
  scene.end_mm = chain ? scene.X.back().p : scene.X.front().p;
}

geometry::Reached ExtendedModel::pose(
    const ModelVector& model, const Trial& trial, Scene& scene) const {
  if (!base_->rig().on_cuboid()) {
    const geometry::RobotModel& robot = base_->robot();
    scene.X.resize(robot.frames.size());
    const auto reached = robot.forward(scene.v, scene.q, trial.assembly, scene.X);
    if (!reached) return reached;
    scene.p_WE = scene.X[0].p;
    set_ends(scene);
    return {};
  }
  const auto at = geometry::planar_pose(
      base_->robot(), scene.v, scene.q, trial.assembly, base_->cuboid_link());
  if (!at) return tl::unexpected(at.error());
  scene.p_WE << at->p_WE, 0.0;
  scene.gamma_rad = cuboid_angle(model, trial, at->link_rad);
  return {};
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
  if (const auto reached = pose(model, trial, scene); !reached) return reached;
  measure(model, trial, sample, scene, extra);
  return {};
}

}  // namespace sixdial::simulation
