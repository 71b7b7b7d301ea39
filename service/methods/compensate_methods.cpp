// A calibration put to use: angles for a target or a plan.
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "report/documents/calibration_json.h"
#include "report/documents/compensation_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/outside_json.h"
#include "report/documents/warnings_document.h"
#include "service/methods/shared_params.h"
#include "service/patient_files.h"
#include "service/recommended_model.h"
#include "service/result_lookup.h"
#include "session/csv.h"
#include "session/plan.h"
#include "studies/extended_command.h"

namespace sixdial::service {
namespace {

constexpr std::string_view kRecommended = "recommended";

/// What `by` says; by default what is recommended for the calibration that the call means.
studies::CompensateBy by_of(const Call& call) {
  const auto word = param_or<std::string>(call.params, "by", std::string(kRecommended));
  if (const auto by = studies::compensate_by_from(word)) return *by;
  return recommended_model(call.service.reader(), calibration_record(call)).recommendation().by;
}

/// Sides of arrival, of as many joints as a call can name.
constexpr std::array<std::string_view, 7> kSides{
    "approach1", "approach2", "approach3", "approach4", "approach5", "approach6", "approach7"};

/// x, y and, of a robot that works in space, z [mm].
std::vector<double> place_in(const Json& params, const geometry::Rig& rig) {
  const bool in_space = rig.instrument.dimensions == 3;
  if (params.contains("z_mm") != in_space) {
    throw studies::StudyError(
        studies::StudyErrorCode::kInvalidParams,
        in_space ? "the target has no z_mm; this robot works in space"
                 : "the target has a z_mm; this robot works in the plane",
        {{"param", "z_mm"}}, in_space ? "Give x, y and z in mm." : "Give x and y in mm.");
  }
  std::vector<double> place;
  for (const char* const key : {"x_mm", "y_mm", "z_mm"}) {
    if (params.contains(key)) place.push_back(params[key].get<double>());
  }
  return place;
}

/// Refuses a side of a joint that the robot does not have.
std::vector<int> sides_in(const Json& params, const geometry::RobotModel& robot) {
  std::vector<int> sides;
  for (std::size_t joint = 0; joint < kSides.size(); ++joint) {
    const std::string key(kSides.at(joint));
    if (params.contains(key)) studies::check_sides(robot, joint + 1, key);
    sides.push_back(param_or(params, key, 0));
  }
  return sides;
}

Json target(const Call& call) {
  const studies::CompensateBy by = by_of(call);
  const bool extended = is_extended(by);
  const db::ResultRecord record = extended ? extending_record(call) : calibration_record(call);
  const Json document = Json::parse(record.json);
  const auto warnings = warnings_of(call.service.reader(), record, document);
  report::check_may_command(warnings);
  geometry::Rig rig = call.service.reader().load_rig(record.session);
  rig.robot.working_mode = studies::working_mode_in_use(warnings, rig);
  const auto mode = geometry::working_mode_from(
      param_or<std::string>(call.params, "mode", geometry::to_string(rig.robot.working_mode)));
  const session::Session session = call.service.reader().load_session(record.session);
  const studies::GivenTarget given = studies::given_target(session, place_in(call.params, rig));
  const std::vector<int> sides = sides_in(call.params, *rig.robot.model);
  Json answer;
  if (extended) {
    studies::CommandMoment moment{.approach = sides};
    if (call.params.contains("temperature_c")) {
      moment.temperature_c = call.params["temperature_c"].get<double>();
    }
    const studies::ExtendedCommand command(
        report::diagnosis_from_json(document).extended_fit, rig, by);
    studies::CommandedTarget commanded = studies::commanded_target(
        command.solve(given.target(), *mode, moment), by, given, *mode, *rig.robot.model);
    commanded.uncertainty = command.uncertainty(commanded, moment);
    answer = report::to_json(commanded);
  } else {
    const auto calibrated = report::calibration_from_json(document);
    studies::CommandedTarget commanded = studies::compensated_target(
        studies::compensation_model(calibrated, rig, by), by, given, *mode);
    commanded.uncertainty = studies::target_uncertainty(calibrated, rig, commanded);
    answer = report::to_json(commanded);
  }
  answer["result"] = record.id.value;
  answer["warnings"] = report::warnings_json(warnings);
  answer["outside_measured"] = report::outside_json(
      studies::outside_measured(studies::measured_area(session), given.p_mm, *mode), 1);
  return answer;
}

Json plan(const Call& call) {
  const studies::CompensateBy by = by_of(call);
  const bool extended = is_extended(by);
  const db::ResultRecord record = extended ? extending_record(call) : calibration_record(call);
  const Json document = Json::parse(record.json);
  const auto warnings = warnings_of(call.service.reader(), record, document);
  report::check_may_command(warnings);
  geometry::Rig rig = call.service.reader().load_rig(record.session);
  rig.robot.working_mode = studies::working_mode_in_use(warnings, rig);
  const session::Plan asked =
      session::parse_plan(call.params.at("plan_csv").get<std::string>(), "plan", rig);
  studies::check_commands_turns(call.service.reader().load_session(record.session), asked);
  std::optional<double> temperature_c;
  if (call.params.contains("temperature_c")) {
    temperature_c = call.params["temperature_c"].get<double>();
  }
  const session::Plan compensated =
      extended
          ? studies::extended_plan(
                asked,
                studies::ExtendedCommand(
                    report::diagnosis_from_json(document).extended_fit, rig, by),
                rig, {.temperature_c = temperature_c})
          : studies::compensated_plan(
                asked,
                studies::compensation_model(report::calibration_from_json(document), rig, by),
                rig);
  const studies::MeasuredArea area =
      studies::measured_area(call.service.reader().load_session(record.session));
  Json answer{
      {"result", record.id.value},
      {"by", studies::to_string(by)},
      {"points", compensated.points.size()},
      {"warnings", report::warnings_json(warnings)},
      {"outside_measured",
       report::outside_json(studies::outside_measured(area, asked, rig), asked.points.size())}};
  if (!call.params.contains("path")) {
    answer["plan_csv"] = session::plan_csv(compensated, session::layout_of(rig));
    return answer;
  }
  const std::filesystem::path path = params::absolute_path(call);
  run_patiently(
      call.service, path,
      [path, text = session::plan_csv(compensated, session::layout_of(rig))] {
        session::write_file(path.string(), text);
      });
  answer["path"] = path.string();
  return answer;
}

constexpr Param kSession{
    .name = "session", .doc = "its newest calibration is used, unless `result` says which"};
constexpr Param kResult{
    .name = "result", .type = ParamType::kInteger, .doc = "number of a calibration", .min = 1};
constexpr std::array<std::string_view, 6> kWays{"recommended", "before",   "kinematics",
                                                "full",        "extended", "extended_full"};
constexpr Param kBy{
    .name = "by",
    .doc =
        "before: nominal parameters; kinematics: identified ones; full: with the learned "
        "residual; extended: robot and named causes of a diagnosis; extended_full: with the "
        "learned residual; default: what result.recommend says",
    .one_of = kWays};
constexpr Param kDiagnosis{
    .name = "diagnosis",
    .type = ParamType::kInteger,
    .doc = "number of a diagnosis, of by extended; default: the newest of the session",
    .min = 1};
constexpr Param kTemperature{
    .name = "temperature_c",
    .type = ParamType::kNumber,
    .doc = "of by extended: when it is commanded; default: at the end of the session",
    .min = -50,
    .max = 100};
constexpr Param side(std::string_view name, std::string_view doc) {
  return {.name = name, .type = ParamType::kInteger, .doc = doc, .min = -1, .max = 1};
}
constexpr Param coordinate(
    std::string_view name, bool required = true,
    std::string_view doc = "of the target, table frame") {
  return {
      .name = name,
      .type = ParamType::kNumber,
      .required = required,
      .doc = doc,
      .min = -1e5,
      .max = 1e5};
}
constexpr std::array kTargetParams{
    kSession,
    kResult,
    coordinate("x_mm"),
    coordinate("y_mm"),
    kBy,
    Param{
        .name = "mode",
        .doc = "working mode; default: the rig's",
        .one_of = params::kModeWords},
    kDiagnosis,
    params::kFromOtherSession,
    kTemperature,
    side(kSides[0], "of by extended: 1 where joint 1 arrives turning up, -1 down, 0 unknown"),
    side(kSides[1], "the same of joint 2"),
    side(kSides[2], "of joint 3"),
    side(kSides[3], "of joint 4"),
    side(kSides[4], "of joint 5"),
    side(kSides[5], "of joint 6"),
    side(kSides[6], "of joint 7"),
    coordinate("z_mm", false, "of the target of a robot in space, which needs it")};
constexpr std::array kPlanParams{
    kSession,
    kResult,
    Param{.name = "plan_csv", .required = true, .doc = "text of a plan file"},
    kBy,
    Param{.name = "path", .doc = "absolute path of a plan file to write instead of plan_csv"},
    kDiagnosis,
    params::kFromOtherSession,
    kTemperature};
constexpr std::array kMethods{
    RpcMethod{
        .name = "compensate.target",
        .summary = "The joint angles to command so that the calibrated robot reaches a target.",
        .params = kTargetParams,
        .result =
            "target_mm, mode, by, theta_rad, nominal_theta_rad, closure_mm, iterations, of "
            "a robot in space uncertainty {position_sd_mm} and joints, result, warnings, "
            "outside_measured {farthest_mm (0: inside of what was "
            "measured), points, points_of_new_mode, words}",
        .example = R"({"session": "demo", "x_mm": 28.0, "y_mm": 48.0})",
        .runs_on = RunsOn::kLong,
        .run = target},
    RpcMethod{
        .name = "compensate.plan",
        .summary = "A plan with the joint angles to command for each of its targets.",
        .params = kPlanParams,
        .result = "result, by, points, warnings, outside_measured (as compensate.target), and "
                  "plan_csv or path",
        .example =
            R"({"session": "demo", "plan_csv": "set,point,target_x_mm,target_y_mm\nG2,0,28,48\n"})",
        .runs_on = RunsOn::kFiles,
        .run = plan},
};

}  // namespace

std::span<const RpcMethod> compensation_methods() { return kMethods; }

}  // namespace sixdial::service
