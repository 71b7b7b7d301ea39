#include "studies/compensate.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "calibration/pipeline.h"
#include "studies/calibrate.h"
#include "studies/network_json.h"

namespace sixdial::studies {
namespace {

constexpr std::array kNames{
    std::pair{CompensateBy::kBefore, std::string_view("before")},
    std::pair{CompensateBy::kKinematics, std::string_view("kinematics")},
    std::pair{CompensateBy::kFull, std::string_view("full")},
    std::pair{CompensateBy::kExtended, std::string_view("extended")}};
constexpr std::size_t kMostNamed = 10;

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

calibration::CompensationModel compensation_model(const Json& document, CompensateBy by) {
  if (document.value("schema", "") != "sixdial.calibration" ||
      document.value("schema_version", 0) != kCalibrationSchemaVersion) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format(
            "compensation needs a sixdial.calibration document of version {}, this is {}",
            kCalibrationSchemaVersion, document.value("schema", "nothing known")),
        {}, "Calibrate the session again.");
  }
  calibration::CompensationModel model;
  const Json& parameters = document.at("parameters");
  for (std::size_t i = 0; i < static_cast<std::size_t>(geometry::kParameterCount); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    model.nominal[k] = parameters.at(i).at("nominal").get<double>();
    model.v[k] = parameters.at(i).at("identified").get<double>();
  }
  if (by == CompensateBy::kBefore) model.v = model.nominal;
  if (by == CompensateBy::kFull) {
    model.correction =
        [networks = std::vector{
             network_from(document.at("anfis").at("x")),
             network_from(document.at("anfis").at("y"))}](const Eigen::Vector2d& q_rad) {
          return Eigen::Vector2d(calibration::anfis_correction(networks, q_rad));
        };
  }
  return model;
}

Json compensated_target(
    const calibration::CompensationModel& model, CompensateBy by,
    const Eigen::Vector2d& target_mm, geometry::WorkingMode mode) {
  return compensation_answer(
      calibration::compensate(model, target_mm, mode), by, target_mm, mode);
}

Json compensation_answer(
    const tl::expected<calibration::Compensation, calibration::CompensationTrouble>& found,
    CompensateBy by, const Eigen::Vector2d& target_mm, geometry::WorkingMode mode) {
  if (!found) {
    throw Error(
        ErrorCode::kBadData, found.error().message,
        {{"target_mm", std::vector{target_mm.x(), target_mm.y()}}},
        "Choose a target inside the workspace, or another working mode.");
  }
  return {
      {"target_mm", {target_mm.x(), target_mm.y()}},
      {"mode", geometry::to_string(mode)},
      {"by", to_string(by)},
      {"theta_rad", {found->q_rad[0], found->q_rad[1]}},
      {"nominal_theta_rad", {found->nominal_q_rad[0], found->nominal_q_rad[1]}},
      {"closure_mm", found->closure_mm},
      {"iterations", found->iterations}};
}

geometry::WorkingMode mode_of(
    const geometry::Rig& rig, const Eigen::Vector2d& q_rad, const Eigen::Vector2d& target_mm) {
  const auto assembly = geometry::assembly_at(rig.robot.nominal, q_rad, target_mm);
  if (!assembly) return rig.robot.working_mode;
  const auto mode = geometry::working_mode_of(rig.robot.nominal, q_rad, *assembly);
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
      point.q = found->q_rad;
    } else if (++troubles <= kMostNamed) {
      named += fmt::format(
          "{}{} {}.{} {}", named.empty() ? "" : "; ", point.set, point.point, point.repeat,
          found.error().message);
    }
  }
  if (troubles > 0) {
    throw Error(
        ErrorCode::kBadData,
        fmt::format("{} points of the plan have no solution: {}", troubles, named), {},
        "Take these points out of the plan, or move them into the workspace.");
  }
  return plan;
}

}  // namespace sixdial::studies
