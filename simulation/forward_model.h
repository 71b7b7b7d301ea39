// The simulation that measured data is held against: joint angles -> robot -> cuboid -> what
// each dial reads (spec 1). Calibration fits its eleven parameters; diagnosis asks what it
// lacks.
//
//   q --(1)-(7)--> p_WE, link angle --mount--> gamma = link - reference + clamp --> face -->
//   delta
//
// Millimetres and radians, frame W. Limits (travel, edges) are told, not applied: a measured
// reading is proof of contact, and a fit must not lose it where the start is a few mm off.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/five_bar.h"
#include "geometry/rig.h"

namespace sixdial::simulation {

/// The ten of geometry::ParameterVector, then the clamp angle of the cuboid [rad].
inline constexpr int kModelParameterCount = geometry::kParameterCount + 1;
inline constexpr int kClamp = geometry::kParameterCount;
using ModelVector = Eigen::Matrix<double, kModelParameterCount, 1>;

/// What the simulation says of one pose.
struct Prediction {
  geometry::ForwardPose pose;
  double gamma_rad = 0.0;
  Eigen::Matrix<double, 2, kModelParameterCount> position_J;  // d(p_WE)/d(model)
  Eigen::VectorXd dial_mm;  // displacement of each dial of the rig, in its order
  /// d(displacement)/d(model), dials x 11; and d(displacement)/d(gamma), which a free mount
  /// needs.
  Eigen::Matrix<double, Eigen::Dynamic, kModelParameterCount> dial_J;
  Eigen::VectorXd dial_J_gamma;
  /// A real dial would show this reading: inside travel and on the face.
  std::vector<bool> in_contact;
};

class ForwardModel {
 public:
  /// Throws std::invalid_argument if the rig's reference pose cannot be reached.
  explicit ForwardModel(geometry::Rig rig);

  /// Nominal robot, clamp angle 0.
  [[nodiscard]] ModelVector nominal() const;
  [[nodiscard]] const geometry::Rig& rig() const { return rig_; }
  /// Angle in W of the cuboid's link at the reference pose [rad].
  [[nodiscard]] double reference_angle_rad() const { return reference_angle_rad_; }

  /// `free_gamma_rad` replaces gamma where the mount is free (dial_J then leaves gamma out).
  /// Without `with_contact`, `in_contact` stays empty.
  [[nodiscard]] tl::expected<Prediction, geometry::KinematicTrouble> predict(
      const ModelVector& model, const Eigen::Vector2d& q_rad, geometry::Assembly assembly,
      std::optional<double> free_gamma_rad = std::nullopt, bool with_contact = true) const;

 private:
  geometry::Rig rig_;
  double reference_angle_rad_ = 0.0;
};

}  // namespace sixdial::simulation
