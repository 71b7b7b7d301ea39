// The simulation that measured data is held against: joint values -> robot -> frames ->
// instrument -> what each channel reads. Calibration fits its parameters; diagnosis asks what
// it lacks. Of the robot and the instrument it knows what their kinds say
// (geometry/robot_kind.h, geometry/instrument_kind.h). For dials on a cuboid (spec 1):
//
//   q --(1)-(7)--> p_WE, link angle --mount--> gamma = link - reference + clamp --> face -->
//   delta
//
// Millimetres and radians, frame W. Limits (travel, edges) are told, not applied: a measured
// reading is proof of contact, and a fit must not lose it where the start is a few mm off.
//
// Example:
//   const ForwardModel model(rig);
//   const auto at = model.predict(model.nominal(), trials[0].q, trials[0].assembly);
//   if (at) show(at->p_WE(), at->reading);  // [mm]: the tool, and what each dial would read
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/instrument_kind.h"
#include "geometry/rig.h"

namespace sixdial::simulation {

/// Values of ForwardModel::parameters(): the robot's, then the instrument's.
using ModelVector = Eigen::VectorXd;

/// The parameters of a rig's forward model by name: the robot's, then the instrument's (the
/// clamp angle of the cuboid).
[[nodiscard]] std::vector<geometry::ParameterInfo> parameters_of(const geometry::Rig& rig);

/// What the simulation says of one pose. Kept by a caller that asks for many, it is filled
/// again without new memory.
struct Prediction {
  geometry::Frames frames;     // of the robot: the tool first
  Eigen::MatrixXd position_J;  // d(p_WE)/d(model), 3 x parameters
  double gamma_rad = 0.0;      // rotation of the cuboid
  Eigen::VectorXd reading;     // by channel: the displacement of each dial, in the rig's order
  Eigen::MatrixXd reading_J;   // d(reading)/d(model), channels x parameters
  Eigen::VectorXd reading_J_gamma;  // d(reading)/d(gamma), which a free mount needs
  /// A real instrument would show this reading: a plunger inside its travel and on the face.
  std::vector<bool> in_contact;
  geometry::Observation observation;  // by frames, before it is carried on to the model

  /// p_WE [mm], 2x1.
  [[nodiscard]] Eigen::Vector2d p_WE() const { return frames.X[0].p.head<2>(); }
};

class ForwardModel {
 public:
  /// Throws std::invalid_argument if the rig cannot have its instrument (the cuboid's reference
  /// pose cannot be reached).
  explicit ForwardModel(geometry::Rig rig);

  [[nodiscard]] const std::vector<geometry::ParameterInfo>& parameters() const {
    return parameters_;
  }
  [[nodiscard]] Eigen::Index parameter_count() const {
    return static_cast<Eigen::Index>(parameters_.size());
  }
  /// How many of them are the robot's; these come first.
  [[nodiscard]] Eigen::Index robot_parameter_count() const { return rig_.robot.nominal.size(); }
  /// Index of a parameter by name, such as "clamp".
  [[nodiscard]] std::optional<Eigen::Index> find(std::string_view parameter) const;

  /// Nominal robot, an instrument without errors (clamp angle 0).
  [[nodiscard]] ModelVector nominal() const;
  [[nodiscard]] const geometry::Rig& rig() const { return rig_; }
  [[nodiscard]] const geometry::RobotModel& robot() const { return *rig_.robot.model; }
  [[nodiscard]] const geometry::InstrumentModel& instrument() const { return *instrument_; }
  /// Angle in W of the cuboid's link at the reference pose [rad].
  [[nodiscard]] double reference_angle_rad() const { return reference_angle_rad_; }
  /// The robot's frame that the cuboid turns with, if any.
  [[nodiscard]] std::optional<int> cuboid_link() const { return cuboid_link_; }

  /// What each channel would read at joint values q. Where the cuboid is held freely, the
  /// caller gives its rotation as `free_gamma_rad`; reading_J then holds gamma fixed. Without
  /// `with_contact`, `in_contact` stays empty.
  [[nodiscard]] tl::expected<Prediction, geometry::KinematicTrouble> predict(
      const ModelVector& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
      std::optional<double> free_gamma_rad = std::nullopt, bool with_contact = true) const;

  /// The same into a prediction that was used before.
  [[nodiscard]] geometry::Reached predict(
      const ModelVector& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
      std::optional<double> free_gamma_rad, bool with_contact, Prediction& into) const;

 private:
  geometry::Rig rig_;
  std::shared_ptr<const geometry::InstrumentModel> instrument_;
  std::vector<geometry::ParameterInfo> parameters_;
  std::optional<int> cuboid_link_;
  double reference_angle_rad_ = 0.0;
};

}  // namespace sixdial::simulation
