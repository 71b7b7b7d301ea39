// Derivatives of the readings with effects by everything that a fit moves: parameters of the
// robot and of the cuboid, and sizes of the effects. The chain goes stage by stage; kinematics
// are differentiated exactly, the stages that effects have a hand in by central differences of
// that stage alone, so that an effect is an ordinary function of numbers.
//
//   (v, x) --bend_joints--> (v', q') --kinematics--> (p_WE, gamma) --measure--> readings
//             differences            exact                        differences
//
// An instrument that is no cuboid with dials differentiates itself by the frames; only what
// effects do to the tool in between is by differences then.
//
// What an effect does depends on the robot (a wrong ratio turns a longer link further), so the
// plain model's derivative is not enough: where an effect is nearly absorbed by the parameters,
// steps along it lead past the optimum.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "simulation/extended_model.h"

namespace sixdial::simulation {

/// A number of an active effect to differentiate by.
struct EffectNumber {
  std::size_t effect = 0;     // index into ExtendedModel::effects()
  std::size_t parameter = 0;  // index into its x
  double step = 0.0;          // a change that is small against what bends
};

class ExtendedSlopes {
 public:
  ExtendedSlopes(const ExtendedModel& extended, std::vector<EffectNumber> numbers);

  /// Number of columns: the model's parameters, then the numbers of the effects.
  [[nodiscard]] Eigen::Index count() const;

  struct Slopes {
    /// d(reading)/d(...), channels x count. Of a trial with readings only the rows of these
    /// channels are filled: a ball lies in one socket of twenty.
    Eigen::MatrixXd reading;
    Eigen::MatrixXd tool;  // d(p_WE)/d(...), 3 x count, p_WE after the effects
  };
  /// Of one sample. The scene is left at the sample's own values.
  [[nodiscard]] tl::expected<void, geometry::KinematicTrouble> at(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
      Slopes& slopes);

 private:
  using Reached = tl::expected<void, geometry::KinematicTrouble>;

  [[nodiscard]] Reached differentiate_joints(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene);
  [[nodiscard]] Reached differentiate_torque(
      const ModelVector& model, const Trial& trial, const Circumstance& sample);
  [[nodiscard]] Reached differentiate_pose(
      const ModelVector& model, const Trial& trial, Scene& scene);
  void differentiate_dials(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
      Slopes& slopes);
  /// Of an instrument that looks at the frames: it differentiates itself.
  void differentiate_channels(
      const ModelVector& model, const Trial& trial, const Circumstance& sample, Scene& scene,
      Slopes& slopes);
  /// d(p_WE, turn)/d(...) of Scene as move_tool leaves them, 6 x count, less that of the
  /// robot's own frames.
  [[nodiscard]] Eigen::MatrixXd differentiate_move(
      const Trial& trial, const Circumstance& sample, Scene& scene);
  /// d(Scene::end_mm)/d(...) and d(Scene::stands_mm)/d(...), 3 x count each.
  void differentiate_ends(
      const Trial& trial, const Scene& scene, Eigen::MatrixXd& end, Eigen::MatrixXd& stands);

  ExtendedModel extended_;  // its effects are moved and put back
  std::vector<EffectNumber> numbers_;
  bool bends_joints_ = false;
  bool bends_parameters_ = false;  // of this sample: v_ is more than the identity
  // Derivatives, one column for each of count().
  Eigen::MatrixXd v_, q_, p_, torque_by_model_;
  Eigen::RowVectorXd gamma_;
  geometry::Frames frames_;
  Scene moved_;
};

}  // namespace sixdial::simulation
