#include "studies/compensate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "calibration/pipeline.h"
#include "calibration/reading_space.h"
#include "geometry/tool.h"
#include "geometry/tool_turn.h"
#include "geometry/units.h"
#include "session/measured_turn.h"
#include "session/trials.h"

namespace sixdial::studies {
namespace {

constexpr std::array kNames{
    std::pair{CompensateBy::kBefore, std::string_view("before")},
    std::pair{CompensateBy::kKinematics, std::string_view("kinematics")},
    std::pair{CompensateBy::kFull, std::string_view("full")},
    std::pair{CompensateBy::kExtended, std::string_view("extended")},
    std::pair{CompensateBy::kExtendedFull, std::string_view("extended_full")}};

/// What the trained residual model adds to the position; empty for a method without one.
calibration::Correction correction_of(const CalibrationResult& result) {
  if (result.networks) {
    return [networks = std::vector{result.networks->x.model, result.networks->y.model}](
               const Eigen::VectorXd& q) { return calibration::anfis_correction(networks, q); };
  }
  if (!result.residual_model) return {};
  return studies::correction_of(
      *result.residual_model, result.inputs.session, "Calibrate the session again.");
}

/// Names and units of joints, unless they are the ones that theta_rad is named for.
std::optional<std::vector<std::string>> other_joints(const geometry::RobotModel& robot) {
  std::vector<std::string> names;
  bool usual = true;
  for (const geometry::JointInfo& joint : robot.joints) {
    names.push_back(fmt::format("{}_{}", joint.name, joint.unit()));
    usual = usual && names.back() == fmt::format("theta{}_rad", names.size());
  }
  return usual ? std::nullopt : std::optional(std::move(names));
}

[[noreturn]] void refuse_turns(
    const session::Session& session, const std::string& what, std::string hint) {
  throw StudyError(
      StudyErrorCode::kBadData, what, {{"session", session.name}}, std::move(hint));
}

}  // namespace

calibration::ToolTarget GivenTarget::target() const {
  if (!turn) return {p_mm};
  return {p_mm, session::frame_of_angles(turn->orientation, turn->angles_rad)};
}

GivenTarget given_target(const session::Session& session, const std::vector<double>& figures) {
  const geometry::Rig& rig = session.rig;
  const auto axes = static_cast<std::size_t>(geometry::Tool(rig).axes());
  const bool turned = axes == 3 && figures.size() == 6;
  if (figures.size() == 6) check_commands_turns(session);
  if (figures.size() != axes && !turned) {
    throw StudyError(
        StudyErrorCode::kInvalidParams,
        fmt::format(
            "the target has {} figures; this robot works in {}", figures.size(),
            axes == 3 ? "space" : "the plane"),
        {{"param", "target"}},
        axes == 3
            ? "Give x,y,z in mm, or with the turn of the tool x,y,z,rx,ry,rz in mm and deg."
            : "Give x,y in mm.");
  }
  GivenTarget given{
      .p_mm =
          Eigen::Map<const Eigen::VectorXd>(figures.data(), static_cast<Eigen::Index>(axes))};
  if (turned) {
    given.turn = AskedTurn{
        geometry::kRadPerDeg * Eigen::Vector3d(figures[3], figures[4], figures[5]),
        rig.instrument.orientation};
  }
  return given;
}

void check_sides(const geometry::RobotModel& robot, std::size_t sides, std::string_view param) {
  if (sides <= robot.joints.size()) return;
  throw StudyError(
      StudyErrorCode::kInvalidParams,
      fmt::format(
          "a side of arrival is given for joint {}; this robot has {} joints", sides,
          robot.joints.size()),
      {{"param", std::string(param)}},
      "Give a side of each joint, the first joint's first; 0, or left out: unknown.");
}

void check_commands_turns(const session::Session& session) {
  const geometry::Robot& robot = session.rig.robot;
  if (!geometry::reaches_any_turn(*robot.model, robot.nominal)) {
    refuse_turns(
        session,
        fmt::format(
            "the target has a turn, and a {} with {} joints cannot turn its tool any way",
            robot.model->kind->in_words, robot.model->joint_count()),
        "Give the place alone: x,y,z in mm (in the plane x,y).");
  }
  if (!session::first_turn(session::layout_of(session.rig))) {
    refuse_turns(
        session,
        fmt::format(
            "the target has a turn, and the session measured none: [instrument] kind = \"{}\" "
            "in rig.toml",
            session.rig.instrument.kind),
        "Give x,y,z in mm, or measure poses (kind = \"pose\": position and orientation).");
  }
  if (!calibration::fits_turns(session.rig)) {
    refuse_turns(
        session,
        "the target has a turn, and no parameter of the robot says how the tool is turned on "
        "its "
        "last link",
        "Write tool = \"frame\" into [robot] of rig.toml, and calibrate again.");
  }
  const PlausibleSession believed = plausible(session);
  const session::SampleLayout layout = session::layout_of(session.rig);
  for (const session::Sample& sample : believed.session.samples) {
    if (!sample.left_out && session::turn_of(sample, layout)) return;
  }
  refuse_turns(
      session, "the target has a turn, and no measured turn of the session is used",
      "See the warnings of sixdial calibrate SESSION; the store of the service keeps no turns, "
      "a "
      "session's folder does.");
}

void check_commands_turns(const session::Session& session, const session::Plan& plan) {
  if (asks_turns(plan)) check_commands_turns(session);
}

bool asks_turns(const session::Plan& plan) {
  return std::ranges::any_of(plan.points, [](const session::PlanPoint& point) {
    return point.target_turn_rad.has_value();
  });
}

void check_knows_turns(
    const CalibrationResult& result, CompensateBy by, const session::Session& session) {
  if (by == CompensateBy::kBefore) {
    // Where there were turns, the nominal robot's tool was set as they say, if it could be.
    const auto told = [](const std::vector<Warning>& warnings, std::string_view code) {
      return std::ranges::find(warnings, code, &Warning::code) != warnings.end();
    };
    const std::vector<Warning> warnings =
        result.warnings ? *result.warnings : plausible(session).warnings;
    if (told(warnings, "tool_turn_not_set")) {
      throw StudyError(
          StudyErrorCode::kBadData,
          "the target has a turn, and the nominal robot's tool could not be set to the "
          "measured "
          "turns",
          {{"session", result.inputs.session}},
          "Write how the tool is turned into [robot] of rig.toml, and calibrate again.");
    }
    if (result.turn_errors && !result.turn_errors->empty()) return;
    if (!told(plausible(session).warnings, "tool_turn_registered")) return;
  } else if (result.turn_errors && turns_were_fitted(*result.turn_errors)) {
    return;
  }
  throw StudyError(
      StudyErrorCode::kBadData,
      "the target has a turn, and the calibration was made without turns of the tool",
      {{"session", result.inputs.session}},
      "Calibrate a session whose G1 has turns of the tool: sixdial calibrate SESSION.");
}

calibration::ToolTarget target_of(const session::PlanPoint& point, const geometry::Rig& rig) {
  if (!point.target_turn_rad) return {point.target_mm};
  return {
      point.target_mm,
      session::frame_of_angles(rig.instrument.orientation, *point.target_turn_rad)};
}

std::string_view to_string(CompensateBy by) {
  for (const auto& [value, name] : kNames) {
    if (value == by) return name;
  }
  return "";
}

std::optional<CompensateBy> compensate_by_from(std::string_view text) {
  for (const auto& [value, name] : kNames) {
    if (name == text) return value;
  }
  return std::nullopt;
}

calibration::CompensationModel compensation_model(
    const CalibrationResult& result, const geometry::Rig& rig, CompensateBy by) {
  const int needed = rig.robot.model->parameter_count();
  if (std::ssize(result.parameters) != needed) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format(
            "the calibration has {} parameters where {} are needed", result.parameters.size(),
            needed),
        {{"session", result.inputs.session}}, "Calibrate the session again.");
  }
  calibration::CompensationModel model{
      .tool = geometry::Tool(rig),
      .nominal = result.nominal(),
      .v = by == CompensateBy::kBefore ? result.nominal() : result.identified()};
  model.frame = result.frame;
  model.measured_at = middles_of(result.measured_joints);
  if (by == CompensateBy::kFull) model.correction = correction_of(result);
  return model;
}

CommandedTarget compensated_target(
    const calibration::CompensationModel& model, CompensateBy by, const GivenTarget& given,
    geometry::WorkingMode mode) {
  return commanded_target(
      calibration::compensate(model, given.target(), mode), by, given, mode,
      model.tool.robot());
}

CommandedTarget compensated_target(
    const calibration::CompensationModel& model, CompensateBy by,
    const geometry::Position& target_mm, geometry::WorkingMode mode) {
  return compensated_target(model, by, GivenTarget{target_mm}, mode);
}

CommandedTarget commanded_target(
    const tl::expected<calibration::Compensation, calibration::CompensationTrouble>& found,
    CompensateBy by, const GivenTarget& given, geometry::WorkingMode mode,
    const geometry::RobotModel& robot) {
  if (!found) {
    throw StudyError(
        StudyErrorCode::kBadData, found.error().message,
        {{"target_mm", std::vector<double>(given.p_mm.begin(), given.p_mm.end())}},
        robot.modes.size() > 1
            ? "Choose a target inside the workspace, or another working mode."
            : "Choose a target inside the workspace.");
  }
  CommandedTarget result{
      .target_mm = given.p_mm,
      .mode = mode,
      .by = by,
      .theta_rad = {found->q.begin(), found->q.end()},
      .nominal_theta_rad = {found->nominal_q.begin(), found->nominal_q.end()},
      .closure_mm = found->closure_mm,
      .iterations = found->iterations,
      .turn = given.turn,
      .joints = other_joints(robot)};
  if (given.turn) result.closure_rad = found->closure_rad;
  return result;
}

geometry::WorkingMode mode_of(
    const geometry::Rig& rig, const Eigen::VectorXd& q, const geometry::Position& target_mm) {
  const geometry::Tool tool(rig);
  const auto assembly = tool.assembly_at(rig.robot.nominal, q, target_mm);
  if (!assembly) return rig.robot.working_mode;
  const auto mode = tool.mode_of(rig.robot.nominal, q, *assembly);
  return mode ? *mode : rig.robot.working_mode;
}

std::optional<geometry::Rig> rig_of_turns(
    geometry::Rig filed, const calibration::CompensationModel& model) {
  if (!calibration::fits_turns(filed)) return filed;
  const geometry::RobotModel& robot = *filed.robot.model;
  // Where the measured poses are: a base that was registered without a frame of the instrument
  // is in this, and best known there.
  const auto measured = model.measured_at.find(filed.robot.working_mode.number);
  const Eigen::VectorXd q = measured == model.measured_at.end()
                                ? Eigen::VectorXd::Zero(robot.joint_count())
                                : measured->second;
  const auto R_filed =
      geometry::turn_of_tool(robot, filed.robot.nominal, q, filed.robot.assembly);
  const auto R_nominal = geometry::turn_of_tool(robot, model.nominal, q, filed.robot.assembly);
  if (!R_filed || !R_nominal) return std::nullopt;
  const Eigen::Matrix3d R =
      model.frame ? Eigen::Matrix3d(model.frame->R.transpose() * *R_nominal) : *R_nominal;
  const auto turned =
      geometry::with_tool_turned(robot, filed.robot.nominal, R_filed->transpose() * R);
  if (!turned) return std::nullopt;
  filed.robot.nominal = *turned;
  return filed;
}

std::optional<geometry::Rig> rig_of_turns(const session::Session& session) {
  if (!calibration::fits_turns(session.rig)) return session.rig;
  const PlausibleSession judged = plausible(session);
  const geometry::Rig& rig = judged.session.rig;
  return rig_of_turns(
      session.rig, {.tool = geometry::Tool(rig),
                    .nominal = rig.robot.nominal,
                    .v = rig.robot.nominal,
                    .measured_at = middles_of(
                        measured_joints_of(session::trials_of(judged.session, ""), rig)),
                    .frame = judged.frame});
}

session::Plan read_plan(
    const std::string& path, const geometry::Rig& filed,
    const std::optional<geometry::Rig>& turned) {
  session::Plan plan = session::read_plan(path, turned.value_or(filed));
  if (turned || !asks_turns(plan)) return plan;
  throw StudyError(
      StudyErrorCode::kBadData,
      "the plan asks for turns of the tool, and the rig file's robot cannot be given the frame "
      "that the instrument measured",
      {{"plan", path}},
      "Turn the tool under robot in rig.toml about as the probe or the board sits, and "
      "calibrate again; or plan places alone.");
}

std::optional<Eigen::VectorXd> near_of(
    const session::PlanPoint& point, const calibration::CompensationModel& model,
    const geometry::Rig& rig) {
  constexpr double kSameTurn_rad = 0.2;  // as far as a command may be from the nominal one
  const calibration::ToolTarget target = model.in_frame(target_of(point, rig));
  if (!target.R) return point.q;
  const auto R =
      geometry::turn_of_tool(*rig.robot.model, model.nominal, point.q, rig.robot.assembly);
  if (!R || geometry::turn_between(*R, *target.R) > kSameTurn_rad) return std::nullopt;
  return point.q;
}

session::Plan compensated_plan(
    session::Plan plan, const calibration::CompensationModel& model, const geometry::Rig& rig) {
  std::string named;
  std::size_t troubles = 0;
  for (session::PlanPoint& point : plan.points) {
    const auto found = calibration::compensate(
        model, target_of(point, rig), mode_of(rig, point.q, point.target_mm),
        near_of(point, model, rig));
    if (found) {
      point.q = found->q;
    } else if (++troubles <= kMostNamed) {
      named += fmt::format(
          "{}{} {}.{} {}", named.empty() ? "" : "; ", point.set, point.point, point.repeat,
          found.error().message);
    }
  }
  if (troubles > 0) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format("{} points of the plan have no solution: {}", troubles, named), {},
        "Take these points out of the plan, or move them into the workspace.");
  }
  return plan;
}

}  // namespace sixdial::studies
