// The forward model with effects: the plain simulation when there are none. Of dials on a
// cuboid every part can be bent; any other instrument looks at the robot's frames, which are
// moved and turned as a whole (Scene::p_WE, Scene::turn_rad).
#pragma once

#include <Eigen/Core>
#include <tl/expected.hpp>
#include <vector>

#include "simulation/circumstances.h"
#include "simulation/effect.h"
#include "simulation/forward_model.h"

namespace sixdial::simulation {

class ExtendedModel {
 public:
  ExtendedModel(const ForwardModel& base, std::vector<ActiveEffect> effects);

  [[nodiscard]] const ForwardModel& base() const { return *base_; }
  [[nodiscard]] const std::vector<ActiveEffect>& effects() const { return effects_; }
  [[nodiscard]] std::vector<ActiveEffect>& effects() { return effects_; }

  /// Runs one sample through every stage. `extra` acts after the others of its stage.
  [[nodiscard]] tl::expected<void, geometry::KinematicTrouble> run(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
      const ActiveEffect* extra = nullptr) const;

  // The stages of `run`, one by one (extended_slopes.h differentiates each).
  using Torque = tl::expected<Eigen::VectorXd, geometry::KinematicTrouble>;
  /// True if an effect needs the torque of the plungers on the joints.
  [[nodiscard]] bool needs_torque(const ActiveEffect* extra = nullptr) const;
  /// Virtual work of the plungers at the rigid pose [N mm]:
  ///   tau_j = -sum over dials F_k d(delta_k)/d(q_j)
  /// with F_k along the dial's axis and delta_k its displacement, which depends on the tool's
  /// place and on the turn of the link that carries the cuboid.
  [[nodiscard]] Torque torque_Nmm(
      const ModelVector& model, const Trial& trial, const Circumstance& sample) const;
  /// q, v and torque_Nmm of the scene are set: bends q and v.
  void bend_joints(
      const Circumstance& sample, Scene& scene, const ActiveEffect* extra = nullptr) const;
  /// gamma [rad] where the bent robot turns the cuboid's link to link_rad in W. A cuboid in a
  /// free mount has the angle that was measured with the sample.
  [[nodiscard]] double cuboid_angle(
      const ModelVector& model, const Trial& trial, double link_rad) const;
  /// p_WE and gamma_rad of the scene are set, and X unless it is dials that measure: what
  /// follows, up to the readings.
  void measure(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
      const ActiveEffect* extra = nullptr) const;
  /// The part of `measure` that moves the tool: p_WE and turn_rad.
  void move_tool(
      const Circumstance& sample, Scene& scene, const ActiveEffect* extra = nullptr) const;
  /// Frames of the scene, which stand where the robot puts them, as move_tool left the tool.
  static void move_frames(Scene& scene);
  /// What the robot does with scene.q and scene.v: p_WE, gamma_rad, X.
  [[nodiscard]] geometry::Reached pose(
      const ModelVector& model, const Trial& trial, Scene& scene) const;
  /// Fills what the scene says of the arm as a whole: its v and X are set.
  void set_ends(Scene& scene) const;
  /// Parameters of the robot that are lengths of its links.
  [[nodiscard]] std::span<const int> growing() const { return growing_; }
  /// Where the base stands, of a robot in space.
  [[nodiscard]] std::span<const int> stands() const { return stands_; }

 private:
  void read_dials(Scene& scene) const;
  void read_channels(const ModelVector& model, const Trial& trial, Scene& scene) const;

  const ForwardModel* base_;
  std::vector<ActiveEffect> effects_;
  std::vector<int> growing_;
  std::vector<int> stands_;  // the base's three coordinates among the robot's parameters
};

}  // namespace sixdial::simulation
