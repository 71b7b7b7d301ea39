// A calibration result put to use: the joint angles that bring the real robot to a target, for
// one target or a whole plan. The same code for the service and for bundles.
//
// Example:
//   const CalibrationResult result = calibrate(session, {.method = "lm"});
//   const auto model = compensation_model(result, rig, CompensateBy::kKinematics);
//   const CommandedTarget target = compensated_target(
//       model, CompensateBy::kKinematics, Eigen::Vector2d(30.0, 45.0), rig.robot.working_mode);
//   target.theta_rad.size();  // -> 2U
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/compensation.h"
#include "geometry/rig.h"
#include "session/plan.h"
#include "session/session.h"
#include "studies/calibration_result.h"
#include "studies/compensate_by.h"
#include "studies/error.h"
#include "studies/target_uncertainty.h"

namespace sixdial::studies {

/// The robot of a calibration of a session on this rig, not one that is_extended(); kFull with
/// the residual model that was trained, if the method has one. Throws StudyError bad_data where
/// that cannot be loaded, or where the calibration has other parameters than the rig's robot.
[[nodiscard]] calibration::CompensationModel compensation_model(
    const CalibrationResult& result, const geometry::Rig& rig, CompensateBy by);

/// How a target asks for the tool to be turned.
struct AskedTurn {
  Eigen::Vector3d angles_rad{0, 0, 0};
  std::string orientation{};  // what they mean: "rotation vector", "intrinsic xyz"
};

/// The joint values to command for one target.
struct CommandedTarget {
  geometry::Position target_mm;
  geometry::WorkingMode mode{};
  CompensateBy by = CompensateBy::kFull;
  std::vector<double> theta_rad{}, nominal_theta_rad{};  // joint by joint
  double closure_mm = 0.0;  // what is left of the way to the target
  int iterations = 0;
  // Of robots in space; empty elsewhere, where nobody asks or nobody knows.
  std::optional<AskedTurn> turn{};
  std::optional<double> closure_rad{};  // what is left of that turn
  std::optional<TargetUncertainty> uncertainty{};
  /// Of a robot that is no five-bar: its joints' names and units, "q1_rad"; `theta_rad` holds
  /// their values.
  std::optional<std::vector<std::string>> joints{};
};

/// A target as people give it.
struct GivenTarget {
  geometry::Position p_mm;
  std::optional<AskedTurn> turn{};
  [[nodiscard]] calibration::ToolTarget target() const;
};

/// x, y [mm] of a robot in the plane; of one in space x, y, z, or with a turn of the tool x, y,
/// z, rx, ry, rz [mm, deg], which the rig file's `orientation` reads. Throws StudyError
/// invalid_params for another number of figures, or for a turn of a robot or a session that
/// has none.
[[nodiscard]] GivenTarget given_target(
    const session::Session& session, const std::vector<double>& figures);

/// Throws StudyError invalid_params where sides of arrival are given for more joints than the
/// robot has; `param` is who gives them.
void check_sides(
    const geometry::RobotModel& robot, std::size_t sides, std::string_view param = "approach");

/// Throws StudyError bad_data where the tool of this session's robot cannot be commanded to
/// turns: the robot cannot take them, nothing measured them, or they are not used.
void check_commands_turns(const session::Session& session);
/// The same for a plan with turns.
void check_commands_turns(const session::Session& session, const session::Plan& plan);

/// Whether a point of the plan asks for a turn of the tool.
[[nodiscard]] bool asks_turns(const session::Plan& plan);

/// Throws StudyError bad_data where turns cannot be commanded: the calibration fitted none, so
/// that its tool sits on the last link as the rig file says; or, by kBefore, the nominal
/// robot's tool could not be set as the turns were measured (tool_turn_not_set), or was not
/// when the calibration was made, though the turns of `session` ask for it
/// (tool_turn_registered).
void check_knows_turns(
    const CalibrationResult& result, CompensateBy by, const session::Session& session);

/// Throws StudyError bad_data for a trouble.
[[nodiscard]] CommandedTarget commanded_target(
    const tl::expected<calibration::Compensation, calibration::CompensationTrouble>& found,
    CompensateBy by, const GivenTarget& given, geometry::WorkingMode mode,
    const geometry::RobotModel& robot);

/// Throws StudyError bad_data that says why the target cannot be had.
[[nodiscard]] CommandedTarget compensated_target(
    const calibration::CompensationModel& model, CompensateBy by, const GivenTarget& given,
    geometry::WorkingMode mode);
[[nodiscard]] CommandedTarget compensated_target(
    const calibration::CompensationModel& model, CompensateBy by,
    const geometry::Position& target_mm, geometry::WorkingMode mode);

/// Where a planned point is to bring the tool, with its turn where the plan asks for one.
[[nodiscard]] calibration::ToolTarget target_of(
    const session::PlanPoint& point, const geometry::Rig& rig);

/// The rig of a session by which a plan with turns is read: where `model` commands by the
/// tool's frame that the instrument measured (studies/plausibility/tool_turn.cpp), the nominal
/// robot of the rig file has its tool turned on the last link so, too. Its base and all else
/// stay. Empty: its parameters cannot be brought there, and a plan with turns cannot be read.
[[nodiscard]] std::optional<geometry::Rig> rig_of_turns(
    geometry::Rig filed, const calibration::CompensationModel& model);

/// The same of what a calibration of this session will command, before it is made.
[[nodiscard]] std::optional<geometry::Rig> rig_of_turns(const session::Session& session);

/// The plan of a file, read by `turned` (rig_of_turns); without it by `filed`. Throws
/// StudyError bad_data where that is missing and the plan asks for turns, and as
/// session::read_plan.
[[nodiscard]] session::Plan read_plan(
    const std::string& path, const geometry::Rig& filed,
    const std::optional<geometry::Rig>& turned);

/// A planned point's joint values, near which its command is looked for. Empty: they turn the
/// tool by the nominal robot otherwise than the point asks. Where they put it is not compared:
/// a base that was registered may stand far from the rig file's, and the joints are near all
/// the same.
[[nodiscard]] std::optional<Eigen::VectorXd> near_of(
    const session::PlanPoint& point, const calibration::CompensationModel& model,
    const geometry::Rig& rig);

/// So many points without a solution are named in an error.
inline constexpr std::size_t kMostNamed = 10;

/// The same points with the angles to command; each in the working mode of its own angles.
/// Throws StudyError bad_data that names the points without a solution.
[[nodiscard]] session::Plan compensated_plan(
    session::Plan plan, const calibration::CompensationModel& model, const geometry::Rig& rig);

/// The working mode that a planned point's angles are in, by the nominal robot; the rig's where
/// that cannot be said.
[[nodiscard]] geometry::WorkingMode mode_of(
    const geometry::Rig& rig, const Eigen::VectorXd& q, const geometry::Position& target_mm);

}  // namespace sixdial::studies
