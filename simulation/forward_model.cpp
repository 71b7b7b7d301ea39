#include "simulation/forward_model.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace sixdial::simulation {

using geometry::Mount;

ForwardModel::ForwardModel(geometry::Rig rig) : rig_(std::move(rig)) {
  const auto reference = geometry::reference_link_angle(rig_);
  if (!reference) {
    throw std::invalid_argument(
        "rig '" + rig_.name + "': reference_pose_mm of the cuboid cannot be used: " +
        std::string(geometry::describe(reference.error())));
  }
  reference_angle_rad_ = *reference;
}

ModelVector ForwardModel::nominal() const {
  ModelVector model;
  model << rig_.robot.nominal, 0.0;
  return model;
}

tl::expected<Prediction, geometry::KinematicTrouble> ForwardModel::predict(
    const ModelVector& model, const Eigen::Vector2d& q_rad, geometry::Assembly assembly,
    std::optional<double> free_gamma_rad, bool with_contact) const {
  const auto derivative =
      geometry::forward_derivative(model.head<geometry::kParameterCount>(), q_rad, assembly);
  if (!derivative) return tl::unexpected(derivative.error());

  Prediction result;
  result.pose = derivative->pose;
  result.position_J << derivative->J_v, Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 1, kModelParameterCount> gamma_J = decltype(gamma_J)::Zero();
  if (rig_.cuboid.mount != Mount::kFree) {
    const int leg = rig_.cuboid.mount == Mount::kDistal1 ? 0 : 1;
    gamma_J << derivative->distal_J_v.row(leg), 1.0;
  } else if (!free_gamma_rad) {
    gamma_J[kClamp] = 1.0;
  }
  result.gamma_rad = free_gamma_rad.value_or(
      geometry::cuboid_angle(rig_, reference_angle_rad_, result.pose, model[kClamp]));

  const auto count = static_cast<Eigen::Index>(rig_.dials.size());
  result.dial_mm.resize(count);
  result.dial_J.resize(count, kModelParameterCount);
  result.dial_J_gamma.resize(count);
  if (with_contact) result.in_contact.resize(rig_.dials.size());
  const geometry::CuboidPose cuboid{result.pose.p_WE, result.gamma_rad};
  const double side_mm = rig_.cuboid.side_mm;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& dial = rig_.dials[static_cast<std::size_t>(i)].geometry;
    const int face = geometry::face_towards(dial, result.gamma_rad);
    const geometry::Contact contact = geometry::contact_on_face(dial, cuboid, side_mm, face);
    result.dial_mm[i] = contact.displacement_mm;
    result.dial_J.row(i) = contact.J.head<2>() * result.position_J + contact.J[2] * gamma_J;
    result.dial_J_gamma[i] = contact.J[2];
    if (with_contact) {
      result.in_contact[static_cast<std::size_t>(i)] =
          geometry::touch(dial, cuboid, side_mm).has_value();
    }
  }
  return result;
}

}  // namespace sixdial::simulation
