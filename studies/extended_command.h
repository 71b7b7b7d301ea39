// Commanding with the extended model of a diagnosis: the joint values at which robot and named
// causes together, and where asked for what a residual model learned of the rest, put the tool
// on the target. What a cause depends on besides them - the
// side that a joint arrives from, temperature, time - is taken from the command.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "calibration/compensation.h"
#include "diagnosis/joint_fit.h"
#include "session/plan.h"
#include "simulation/extended_model.h"
#include "studies/compensate.h"
#include "studies/diagnosis_result.h"
#include "studies/error.h"
#include "studies/target_uncertainty.h"

namespace sixdial::studies {

/// Circumstances of one command. Empty: as at the end of the diagnosed session.
struct CommandMoment {
  std::vector<int> approach{};      // sign of each joint's last move, 0 or missing: unknown
  Eigen::Vector3d travel{0, 0, 0};  // unit vector of the tool's last move, 0: unknown
  std::optional<double> temperature_c{};
  std::optional<double> time_h{};  // since the first sample of the diagnosed session
};

/// What commanding by a fit to these readings needs: its robot and causes, and what the last
/// sample knew of time and temperature. Without a residual model.
[[nodiscard]] ExtendedFit commands_of(
    const diagnosis::Readings& readings, const diagnosis::JointFit& fit);

/// Throws StudyError bad_data where the diagnosis was made without turns of the tool, so that
/// its fit cannot command any (compensate.h has the same of a calibration).
void check_knows_turns(const ExtendedFit& fit);

class ExtendedCommand {
 public:
  /// `fit`: of the diagnosis of a session on this rig; `by`: kExtended or kExtendedFull. Throws
  /// StudyError bad_data where it has other parameters, a cause that this program or this rig
  /// does not have, or no residual model that is asked for.
  ExtendedCommand(
      const ExtendedFit& fit, const geometry::Rig& rig,
      CompensateBy by = CompensateBy::kExtended);

  /// Solves for the joint values like calibration::compensate, with the forces of the dials
  /// that would touch at the target.
  [[nodiscard]] tl::expected<calibration::Compensation, calibration::CompensationTrouble> solve(
      const calibration::ToolTarget& target, geometry::WorkingMode mode,
      const CommandMoment& moment,
      const std::optional<Eigen::VectorXd>& near = std::nullopt) const;
  [[nodiscard]] tl::expected<calibration::Compensation, calibration::CompensationTrouble> solve(
      const geometry::Position& target_mm, geometry::WorkingMode mode,
      const CommandMoment& moment,
      const std::optional<Eigen::VectorXd>& near = std::nullopt) const;
  /// The same for a move from other joint values: joints whose side `moment` does not say
  /// arrive from the side of the solution itself.
  [[nodiscard]] tl::expected<calibration::Compensation, calibration::CompensationTrouble>
  solve_after(
      const Eigen::VectorXd& previous_q, const calibration::ToolTarget& target,
      geometry::WorkingMode mode, CommandMoment moment,
      const std::optional<Eigen::VectorXd>& near) const;
  /// Its robot alone.
  [[nodiscard]] calibration::CompensationModel without_causes() const;

  /// How well robot and causes know where they put the tool at these joint values; empty where
  /// the diagnosis says nothing of it. Neither what a residual model learned is in it, nor how
  /// well the error curve of a joint is known.
  [[nodiscard]] std::optional<TargetUncertainty> uncertainty(
      const CommandedTarget& commanded, const CommandMoment& moment) const;

  /// Where the extended model says the tool is, and how it is turned; in the plane the turn
  /// says nothing.
  [[nodiscard]] tl::expected<geometry::Pose<double>, geometry::KinematicTrouble> pose(
      const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const;
  /// Where it says the tool is [mm].
  [[nodiscard]] tl::expected<geometry::Position, geometry::KinematicTrouble> position(
      const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const;
  [[nodiscard]] const simulation::ModelVector& model() const { return model_; }
  [[nodiscard]] const std::vector<simulation::ActiveEffect>& effects() const {
    return effects_;
  }

 private:
  using ToolPose = tl::expected<geometry::Pose<double>, geometry::KinematicTrouble>;
  /// The same by other figures of robot and causes.
  [[nodiscard]] ToolPose pose_of(
      const simulation::ModelVector& model,
      const std::vector<simulation::ActiveEffect>& effects, const Eigen::VectorXd& q,
      geometry::Assembly assembly, const CommandMoment& moment) const;
  /// d(position, turn)/d(model, sizes of the causes) by differences, 6 rows; empty: no pose.
  [[nodiscard]] std::optional<Eigen::MatrixXd> slopes_of(
      const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const;
  [[nodiscard]] simulation::Circumstance circumstance(
      const CommandMoment& moment, std::vector<double> plunger_force_n) const;
  /// Of each dial on the cuboid, along its axis.
  [[nodiscard]] std::vector<double> forces_at(
      const Eigen::VectorXd& q, geometry::Assembly assembly) const;

  simulation::ForwardModel base_;
  simulation::ModelVector model_;
  std::vector<simulation::ActiveEffect> effects_;
  calibration::Correction learned_;  // empty: none
  int order_ = 0;
  double last_time_h_ = 0.0;
  double last_temperature_degC_ = 20.0;
  Eigen::VectorXd nominal_;  // of the robot
  std::map<int, Eigen::VectorXd> measured_at_;
  std::optional<geometry::Similarity> frame_;
  std::optional<Eigen::MatrixXd> covariance_;
  double left_sd_mm_ = 0.0;  // of smooth errors without a name
  int axes_ = 2;             // in which the tool moves
};

/// When the points of a plan are commanded. Empty: as at the end of the diagnosed session.
struct PlanMoment {
  std::optional<double> temperature_c{};
  std::optional<double> first_time_h{};  // since the first sample of the diagnosed session
  double hours_a_point = 0.0;
};

/// The plan with the joint values to command. Each point's last moves are those from the side
/// that the plan asks for, which the collector makes from a place short before it, else those
/// from the point before. Throws StudyError bad_data that names the points without a solution.
[[nodiscard]] session::Plan extended_plan(
    session::Plan plan, const ExtendedCommand& command, const geometry::Rig& rig,
    const PlanMoment& moment = {});

}  // namespace sixdial::studies
