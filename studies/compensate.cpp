#include "studies/compensate.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "calibration/pipeline.h"
#include "geometry/tool.h"

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

}  // namespace

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
    const calibration::CompensationModel& model, CompensateBy by,
    const geometry::Position& target_mm, geometry::WorkingMode mode) {
  return commanded_target(calibration::compensate(model, target_mm, mode), by, target_mm, mode);
}

CommandedTarget commanded_target(
    const tl::expected<calibration::Compensation, calibration::CompensationTrouble>& found,
    CompensateBy by, const geometry::Position& target_mm, geometry::WorkingMode mode) {
  if (!found) {
    throw StudyError(
        StudyErrorCode::kBadData, found.error().message,
        {{"target_mm", std::vector<double>(target_mm.begin(), target_mm.end())}},
        "Choose a target inside the workspace, or another working mode.");
  }
  return {
      .target_mm = target_mm,
      .mode = mode,
      .by = by,
      .theta_rad = {found->q.begin(), found->q.end()},
      .nominal_theta_rad = {found->nominal_q.begin(), found->nominal_q.end()},
      .closure_mm = found->closure_mm,
      .iterations = found->iterations};
}

geometry::WorkingMode mode_of(
    const geometry::Rig& rig, const Eigen::VectorXd& q, const geometry::Position& target_mm) {
  const geometry::Tool tool(rig);
  const auto assembly = tool.assembly_at(rig.robot.nominal, q, target_mm);
  if (!assembly) return rig.robot.working_mode;
  const auto mode = tool.mode_of(rig.robot.nominal, q, *assembly);
  return mode ? *mode : rig.robot.working_mode;
}

session::Plan compensated_plan(
    session::Plan plan, const calibration::CompensationModel& model, const geometry::Rig& rig) {
  std::string named;
  std::size_t troubles = 0;
  for (session::PlanPoint& point : plan.points) {
    const auto found = calibration::compensate(
        model, point.target_mm, mode_of(rig, point.q, point.target_mm), point.q);
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
