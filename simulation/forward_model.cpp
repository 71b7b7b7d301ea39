#include "simulation/forward_model.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "geometry/units.h"

namespace sixdial::simulation {
namespace {

using geometry::Mount;

constexpr double kClampChange_rad = 1.0 / 60.0;

}  // namespace

std::vector<geometry::ParameterInfo> parameters_of(const geometry::Rig& /*rig*/) {
  std::vector<geometry::ParameterInfo> result(
      geometry::kParameters.begin(), geometry::kParameters.end());
  result.push_back({"clamp", "", "deg", geometry::kDegPerRad, "rad", kClampChange_rad});
  return result;
}

ForwardModel::ForwardModel(geometry::Rig rig)
    : rig_(std::move(rig)), parameters_(parameters_of(rig_)) {
  const auto reference = geometry::reference_link_angle(rig_);
  if (!reference) {
    throw std::invalid_argument(
        "rig '" + rig_.name + "': reference_pose_mm of the cuboid cannot be used: " +
        std::string(geometry::describe(reference.error())));
  }
  reference_angle_rad_ = *reference;
}

std::optional<Eigen::Index> ForwardModel::find(std::string_view parameter) const {
  const auto found = std::ranges::find(parameters_, parameter, &geometry::ParameterInfo::name);
  if (found == parameters_.end()) return std::nullopt;
  return found - parameters_.begin();
}

ModelVector ForwardModel::nominal() const {
  ModelVector model = ModelVector::Zero(parameter_count());
  model.head(rig_.robot.nominal.size()) = rig_.robot.nominal;
  return model;
}

tl::expected<Prediction, geometry::KinematicTrouble> ForwardModel::predict(
    const ModelVector& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
    std::optional<double> free_gamma_rad, bool with_contact) const {
  constexpr int kClamp = geometry::kParameterCount;
  constexpr int kCount = kClamp + 1;
  const auto derivative =
      geometry::forward_derivative(model.head<geometry::kParameterCount>(), q, assembly);
  if (!derivative) return tl::unexpected(derivative.error());

  Prediction result;
  result.pose = derivative->pose;
  Eigen::Matrix<double, 2, kCount> position_J;
  position_J << derivative->J_v, Eigen::Vector2d::Zero();
  result.position_J = position_J;
  Eigen::Matrix<double, 1, kCount> gamma_J = decltype(gamma_J)::Zero();
  if (rig_.cuboid.mount != Mount::kFree) {
    const int leg = rig_.cuboid.mount == Mount::kDistal1 ? 0 : 1;
    gamma_J << derivative->distal_J_v.row(leg), 1.0;
  } else if (!free_gamma_rad) {
    gamma_J[kClamp] = 1.0;
  }
  result.gamma_rad = free_gamma_rad.value_or(
      geometry::cuboid_angle(rig_, reference_angle_rad_, result.pose, model[kClamp]));

  const auto count = static_cast<Eigen::Index>(rig_.dials.size());
  result.reading.resize(count);
  result.reading_J.resize(count, kCount);
  result.reading_J_gamma.resize(count);
  if (with_contact) result.in_contact.resize(rig_.dials.size());
  const geometry::CuboidPose cuboid{result.pose.p_WE, result.gamma_rad};
  const double side_mm = rig_.cuboid.side_mm;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& dial = rig_.dials[static_cast<std::size_t>(i)].geometry;
    const int face = geometry::face_towards(dial, result.gamma_rad);
    const geometry::Contact contact = geometry::contact_on_face(dial, cuboid, side_mm, face);
    result.reading[i] = contact.displacement_mm;
    result.reading_J.row(i) = contact.J.head<2>() * position_J + contact.J[2] * gamma_J;
    result.reading_J_gamma[i] = contact.J[2];
    if (with_contact) {
      result.in_contact[static_cast<std::size_t>(i)] =
          geometry::touch(dial, cuboid, side_mm).has_value();
    }
  }
  return result;
}

}  // namespace sixdial::simulation
