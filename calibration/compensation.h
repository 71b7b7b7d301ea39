// The joint values to command so that the tool really arrives: the inverse problem
// f(v, q) + c(q) = target with the identified parameters v and the learned residual c, Fig. 7.
//
//   nominal inverse -> branch -> identified inverse -> damped Newton with J_q + dc/dq -> q
//
// A target may say how the tool is to be turned as well; else it is turned as it comes. Solved,
// not stepped once: what is left is below kClosure_mm and kClosure_rad. Millimetre, radian,
// frame W.
// Degenerate: targets out of the identified robot's reach, close to a stretched or folded leg,
// a correction so steep that another branch would be taken. Each is named.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "geometry/registration.h"
#include "geometry/tool.h"

namespace sixdial::calibration {

/// Learned residual of the position [mm] at joint values; empty: none.
using Correction = std::function<Eigen::VectorXd(const Eigen::VectorXd& q)>;

/// Where the tool is to be, and, of a robot that can turn it any way, how it is to be turned.
struct ToolTarget {
  geometry::Position p_mm;             // in W
  std::optional<Eigen::Matrix3d> R{};  // R_WE; empty: as it comes
};

struct CompensationModel {
  geometry::Tool tool;
  Eigen::VectorXd nominal;  // what the controller believes: gives the branch
  Eigen::VectorXd v;        // identified
  Correction correction{};
  /// Where the joints stood when v and the correction were found, by working mode: the middle
  /// of their values. An angle is the same a whole turn on, a learned correction is not:
  /// answers are on this turn, whoever asks. A mode that is not here was not measured.
  std::map<int, Eigen::VectorXd> measured_at{};
  /// Brings targets into the frame of v; empty: they are in it.
  std::optional<geometry::Similarity> frame{};
  /// What the model adds to the robot's own turn of the tool: a rotation vector in W [rad];
  /// empty: nothing.
  Correction turn_correction{};

  [[nodiscard]] geometry::Position in_frame(const geometry::Position& target_mm) const {
    return frame ? geometry::Position((*frame)(target_mm)) : target_mm;
  }
  [[nodiscard]] ToolTarget in_frame(const ToolTarget& target) const;
  /// What an inverse is asked to be near: the turn that was measured, else `near`. In space,
  /// where joint values say more than a turn, `near` on the turn that was measured.
  [[nodiscard]] std::optional<Eigen::VectorXd> turn_in(
      geometry::WorkingMode mode, const std::optional<Eigen::VectorXd>& near) const;
};

inline constexpr double kClosure_mm = 1e-9;
inline constexpr double kClosure_rad = 1e-11;

struct CompensationSettings {
  double closure_mm = kClosure_mm;
  double closure_rad = kClosure_rad;
  int max_iterations = 50;
  /// Further than this from the nominal joint values nothing is commanded: a robot is
  /// millimetres off, not a tenth of its workspace.
  double most_change_rad = 0.2;
  double most_change_mm = 20.0;  // of a joint that slides
};

struct Compensation {
  Eigen::VectorXd q;          // to command, on the turn of the nominal angles
  Eigen::VectorXd nominal_q;  // what would be commanded without calibration
  double closure_mm = 0.0;    // |f(v, q) + c(q) - target| left
  int iterations = 0;
  double closure_rad = 0.0;  // of the turn, where one is asked for
};

struct CompensationTrouble {
  enum class Kind {
    kNominalUnreachable,  // the nominal robot cannot take the target in this working mode
    kUnreachable,         // the identified robot cannot
    kOffBranch,  // the solution is too far from the nominal joint values or in another mode
    kNotConverged,
    kNoSuchTurn,  // the robot cannot turn its tool any way
  } kind;
  std::string message;  // what, where
};

/// `near`: the turn of the nominal angles in a mode that was not measured (default: in (-pi,
/// pi]); in space the joint values that the answer is to be near.
[[nodiscard]] tl::expected<Compensation, CompensationTrouble> compensate(
    const CompensationModel& model, const ToolTarget& target, geometry::WorkingMode mode,
    const std::optional<Eigen::VectorXd>& near = std::nullopt,
    const CompensationSettings& settings = {});
/// The same for a place alone.
[[nodiscard]] tl::expected<Compensation, CompensationTrouble> compensate(
    const CompensationModel& model, const geometry::Position& target_mm,
    geometry::WorkingMode mode, const std::optional<Eigen::VectorXd>& near = std::nullopt,
    const CompensationSettings& settings = {});

/// f(v, q) + c(q) [mm]: where the model says the tool is.
[[nodiscard]] tl::expected<geometry::Position, geometry::KinematicTrouble> modelled_position(
    const CompensationModel& model, const Eigen::VectorXd& q, geometry::Assembly assembly);
/// R_WE: how it says that the tool is turned.
[[nodiscard]] tl::expected<Eigen::Matrix3d, geometry::KinematicTrouble> modelled_turn(
    const CompensationModel& model, const Eigen::VectorXd& q, geometry::Assembly assembly);

/// Joint values of the tool target by parameters v: its place, and its turn where it has one.
[[nodiscard]] tl::expected<Eigen::VectorXd, geometry::KinematicTrouble> joints_for(
    const geometry::Tool& tool, const Eigen::VectorXd& v, const ToolTarget& target,
    geometry::WorkingMode mode, const std::optional<Eigen::VectorXd>& near);

}  // namespace sixdial::calibration
