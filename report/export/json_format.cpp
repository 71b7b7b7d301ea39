// Everything that the model has, as the document "sixdial.robot" (doc/schemas/robot.json): the
// parameters, of an arm also its joints as fixed frames and axes, the effects with their
// numbers and their statements, what a residual model learned, and poses to try a copy at.
#include <algorithm>

#include "report/documents/json.h"
#include "report/documents/measured_joints_json.h"
#include "report/documents/network_json.h"
#include "report/documents/stored_residual_json.h"
#include "report/export/holding.h"
#include "report/export/joint_chain.h"
#include "report/export/source_code.h"
#include "simulation/effect_in_code.h"

namespace sixdial::report {
namespace {

constexpr int kRobotSchemaVersion = 1;
constexpr std::size_t kMostPoses = 12;

HeldModel hold(const studies::ExportedModel& full, const ExportOptions&) {
  Holding holding(full);
  for (const simulation::ActiveEffect& each : full.effects) {
    if (!acts_on_robot(each)) {
      holding.note(words_of(each) + " is of what measures: it moves neither joints nor tool");
    } else if (simulation::find_effect_in_code(each.effect->cause) == nullptr) {
      holding.note(words_of(each) + " is held by its numbers alone, without statements");
    }
  }
  return holding.done();
}

Json pose_json(const geometry::Pose<double>& pose) {
  return {{"p_mm", write(pose.p)}, {"R", write(pose.R)}};
}

Json joints_json(const geometry::RobotModel& robot) {
  Json joints = Json::array();
  for (const geometry::JointInfo& each : robot.joints) {
    const bool turns = each.kind == geometry::JointKind::kRevolute;
    joints.push_back(
        {{"name", each.name},
         {"kind", turns ? "revolute" : "prismatic"},
         {"unit", each.unit()},
         {"usual_low", each.low},
         {"usual_high", each.high}});
  }
  return joints;
}

Json parameters_json(const studies::ExportedModel& model) {
  Json rows = Json::array();
  for (std::size_t k = 0; k < model.robot().parameters.size(); ++k) {
    const geometry::ParameterInfo& info = model.robot().parameters[k];
    const auto at = static_cast<Eigen::Index>(k);
    rows.push_back(
        {{"name", info.name},
         {"unit", info.unit},
         {"meaning", info.meaning},
         {"rig_key", info.rig_key},
         {"nominal", write(model.nominal[at])},
         {"value", write(model.model[at])}});
  }
  return rows;
}

Json robot_json(const studies::ExportedModel& model) {
  const geometry::RobotModel& robot = model.robot();
  const auto branches = [](const std::vector<geometry::BranchInfo>& all) {
    Json list = Json::array();
    for (const geometry::BranchInfo& each : all) {
      list.push_back({{"number", each.number}, {"name", each.name}});
    }
    return list;
  };
  Json twice = Json::array();
  for (const geometry::SaidTwice& each : robot.said_twice) {
    twice.push_back({{"name", each.name}, {"by", each.by}});
  }
  const geometry::Robot& stands = model.base->rig().robot;
  return {
      {"kind", robot.kind->name},
      {"in_words", robot.kind->in_words},
      {"axes", robot.axes},
      {"joints", joints_json(robot)},
      {"parameters", parameters_json(model)},
      {"said_twice", std::move(twice)},
      {"assembly", static_cast<int>(stands.assembly)},
      {"assemblies", branches(robot.assemblies)},
      {"working_mode", robot.mode_name(stands.working_mode)},
      {"modes", branches(robot.modes)}};
}

Json chain_json(const studies::ExportedModel& model) {
  if (!is_arm(model)) return nullptr;
  const JointChain chain = joint_chain(model, false);
  Json joints = Json::array();
  for (const ChainJoint& each : chain.joints) {
    const bool turns = each.kind == geometry::JointKind::kRevolute;
    joints.push_back(
        {{"name", each.name},
         {"kind", turns ? "revolute" : "prismatic"},
         {"origin", pose_json(each.origin)},
         {"axis", write(each.axis)},
         {"link_end_mm", write(each.mark_mm)},
         {"q", each.joint},
         {"ratio", each.follows.empty() ? 1.0 : each.ratio},
         {"offset", each.follows.empty() ? 0.0 : each.offset}});
  }
  return {
      {"base", pose_json(chain.base)},
      {"upright", pose_json(chain.upright)},
      {"joints", std::move(joints)},
      {"tool", pose_json(chain.tool)}};
}

Json effect_json(const simulation::ActiveEffect& effect, const geometry::RobotModel& robot) {
  Json parameters = Json::array();
  for (std::size_t k = 0; !effect.effect->is_curve && k < effect.x.size(); ++k) {
    const auto info =
        simulation::parameter_at(*effect.effect, effect.place, static_cast<int>(k));
    if (!info) continue;
    parameters.push_back(
        {{"name", info->name}, {"unit", info->unit}, {"value", write(effect.x[k])}});
  }
  const EffectLines lines = effect_lines(
      effect, robot, "x", [](std::size_t k) { return "x[" + std::to_string(k) + "]"; });
  const bool known = simulation::find_effect_in_code(effect.effect->cause) != nullptr;
  return {
      {"cause", effect.effect->cause},
      {"where", effect.place.name},
      {"words", words_of(effect)},
      {"moves_robot", acts_on_robot(effect)},
      {"parameters", std::move(parameters)},
      {"x", write(effect.x)},
      {"joint_statements", known ? Json(lines.joints) : Json(nullptr)},
      {"tool_statements", known ? Json(lines.tool) : Json(nullptr)}};
}

Json learned_json(const studies::ExportedModel& model) {
  if (model.networks) {
    return {
        {"name", model.learned_by},
        {"x", write(model.networks->x)},
        {"y", write(model.networks->y)}};
  }
  if (!model.residual_model) return nullptr;
  return write(*model.residual_model);
}

/// Spread over the session; each as if it were commanded now, from the side that it came from.
Json poses_json(const studies::ExportedModel& model) {
  Json poses = Json::array();
  const std::size_t count = std::min(kMostPoses, model.poses.size());
  for (std::size_t i = 0; i < count; ++i) {
    const studies::ModelPose& measured = model.poses[i * model.poses.size() / count];
    const Eigen::VectorXd& sides = measured.sample.approach;
    studies::ModelPose pose = studies::commanded_pose(
        model, measured.q, measured.assembly, {sides.begin(), sides.end()});
    pose.sample.travel = measured.sample.travel;
    const auto at = studies::tool_pose(model, pose);
    if (!at) continue;
    Json row{
        {"q", write(pose.q)},
        {"assembly", static_cast<int>(pose.assembly)},
        {"approach", write(pose.sample.approach)},
        {"travel", write(pose.sample.travel)},
        {"tool", pose_json(*at)}};
    poses.push_back(std::move(row));
  }
  return poses;
}

std::string write_document(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions&) {
  const bool extended = full.by == studies::CompensateBy::kExtended;
  Json effects = Json::array();
  for (const simulation::ActiveEffect& each : full.effects) {
    effects.push_back(effect_json(each, full.robot()));
  }
  const Json document{
      {"schema", "sixdial.robot"},
      {"schema_version", kRobotSchemaVersion},
      {"model", studies::to_string(full.by)},
      {"made_from",
       {{"result", extended ? "diagnosis" : "calibration"},
        {"session", full.inputs.session},
        {"rig", full.inputs.rig_name},
        {"created_utc", full.created_utc},
        {"data_hash", full.inputs.data_hash},
        {"rig_hash", full.inputs.rig_hash},
        {"seed", full.inputs.seed},
        {"version", full.inputs.version}}},
      {"robot", robot_json(full)},
      {"chain", chain_json(full)},
      {"effects", std::move(effects)},
      {"learned", learned_json(full)},
      {"at",
       {{"sample", full.order + 1},
        {"time_h", full.time_h},
        {"temperature_degC", full.temperature_degC}}},
      {"frame", write(full.frame)},
      {"notes", held.notes},
      {"poses", poses_json(full)}};
  return document.dump(1) + "\n";
}

}  // namespace

extern constinit const ExportFormat json_format;
constinit const ExportFormat json_format{
    .name = "json",
    .in_words = "JSON",
    .about = "everything, as the document sixdial.robot",
    .file_name = "robot.json",
    .hold = hold,
    .write = write_document};

}  // namespace sixdial::report
