#include "studies/exported_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "session/trials.h"
#include "simulation/circumstances.h"
#include "simulation/extended_model.h"
#include "simulation/weight.h"
#include "studies/compensate.h"
#include "studies/extended_command.h"
#include "studies/plausibility.h"

namespace sixdial::studies {
namespace {

using geometry::KinematicTrouble;
using geometry::Pose;
using simulation::ExtendedModel;

/// The poses of a session as far as it is believed, with what the model makes of their past.
std::vector<ModelPose> poses_of(
    const session::Session& believed, const simulation::ForwardModel& base,
    const simulation::ModelVector& at) {
  const std::vector<simulation::Trial> trials = session::trials_of(believed, "");
  std::vector<simulation::Circumstance> samples =
      simulation::circumstances_of(base, at, trials);
  std::vector<ModelPose> poses;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    poses.push_back({trials[t].q, trials[t].assembly, std::move(samples[t])});
  }
  return poses;
}

/// Takes session and rig; the rest is the caller's.
ExportedModel begun(const session::Session& session, session::Session& believed) {
  believed = plausible(session).session;
  ExportedModel model;
  model.base = std::make_shared<const simulation::ForwardModel>(believed.rig);
  model.model = model.base->nominal();
  return model;
}

Pose<double> plain_pose(
    const geometry::RobotModel& robot, const Eigen::VectorXd& v, const Eigen::VectorXd& q,
    geometry::Assembly assembly, std::vector<Pose<double>>& X, KinematicTrouble* trouble) {
  X.resize(robot.frames.size());
  const auto reached = robot.forward(v, q, assembly, X);
  if (!reached) *trouble = reached.error();
  return reached ? X.front() : Pose<double>{Eigen::Vector3d::Constant(std::nan(""))};
}

/// Of one model for many poses.
class ToolOf {
 public:
  explicit ToolOf(const ExportedModel& model)
      : model_(model), extended_(*model.base, model.effects), v_(model.parameters()) {}

  tl::expected<Pose<double>, KinematicTrouble> at(const ModelPose& pose) {
    KinematicTrouble trouble{};
    Pose<double> result;
    if (model_.effects.empty()) {
      result = plain_pose(model_.robot(), v_, pose.q, pose.assembly, X_, &trouble);
    } else {
      simulation::Trial trial;
      trial.q = pose.q;
      trial.assembly = pose.assembly;
      const auto ran = extended_.run(model_.model, trial, pose.sample, scene_);
      if (!ran) return tl::unexpected(ran.error());
      // Dials on a cuboid look at no frame: how the tool is turned is the robot's alone.
      result = model_.base->rig().on_cuboid()
                   ? plain_pose(model_.robot(), scene_.v, scene_.q, pose.assembly, X_, &trouble)
                   : scene_.X.front();
      if (result.p.allFinite()) result.p = scene_.p_WE;
    }
    if (!result.p.allFinite()) return tl::unexpected(trouble);
    return result;
  }

 private:
  const ExportedModel& model_;
  ExtendedModel extended_;
  Eigen::VectorXd v_;
  simulation::Scene scene_;
  std::vector<Pose<double>> X_;
};

MissBetween summed(
    const std::vector<ModelPose>& poses,
    const std::function<std::optional<double>(const ModelPose&)>& apart_mm) {
  MissBetween result;
  for (const ModelPose& pose : poses) {
    const std::optional<double> apart = apart_mm(pose);
    if (!apart) continue;
    ++result.poses;
    result.mean_mm += *apart;
    result.max_mm = std::max(result.max_mm, *apart);
  }
  if (result.poses > 0) result.mean_mm /= result.poses;
  return result;
}

}  // namespace

ExportedModel exported_model(const CalibrationResult& result, const session::Session& session) {
  session::Session believed;
  ExportedModel model = begun(session, believed);
  calibration::CompensationModel full =
      compensation_model(result, session.rig, CompensateBy::kFull);
  model.by = CompensateBy::kKinematics;
  model.inputs = result.inputs;
  model.created_utc = result.created_utc;
  model.model.head(full.v.size()) = full.v;
  model.nominal = full.nominal;
  model.learned = std::move(full.correction);
  model.residual_model = result.residual_model;
  model.networks = result.networks;
  if (result.networks) model.learned_by = "anfis";
  if (result.residual_model) model.learned_by = result.residual_model->name;
  model.frame = result.frame;
  model.poses = poses_of(believed, *model.base, model.model);
  if (!model.poses.empty()) {
    const simulation::Circumstance& last = model.poses.back().sample;
    model.order = last.order;
    model.time_h = last.time_h;
    model.temperature_degC = last.temperature_degC;
  }
  return model;
}

ExportedModel exported_model(const DiagnosisResult& result, const session::Session& session) {
  session::Session believed;
  ExportedModel model = begun(session, believed);
  const ExtendedFit& fit = result.extended_fit;
  const ExtendedCommand command(fit, session.rig);
  model.by = CompensateBy::kExtended;
  model.inputs = result.inputs;
  model.created_utc = result.created_utc;
  model.model = command.model();
  model.nominal = model.base->nominal().head(model.base->robot_parameter_count());
  if (fit.nominal && std::ssize(*fit.nominal) == model.nominal.size()) {
    model.nominal =
        Eigen::Map<const Eigen::VectorXd>(fit.nominal->data(), model.nominal.size());
  }
  model.effects = command.effects();
  if (fit.residual_model) {
    model.learned = correction_of(*fit.residual_model, "", "Diagnose the session again.");
    model.residual_model = fit.residual_model;
    model.learned_by = fit.residual_model->name;
  }
  model.order = fit.last_order;
  model.time_h = fit.last_time_h;
  model.temperature_degC = fit.last_temperature_degC;
  model.frame = fit.frame;
  model.poses = poses_of(believed, *model.base, model.model);
  return model;
}

ModelPose commanded_pose(
    const ExportedModel& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
    const std::vector<double>& approach) {
  ModelPose pose{q, assembly};
  const std::size_t dials = model.base->rig().dials.size();
  simulation::Circumstance& sample = pose.sample;
  sample.order = model.order + 1;
  sample.time_h = model.time_h;
  sample.temperature_degC = model.temperature_degC;
  sample.approach.setZero(model.robot().joint_count());
  for (std::size_t i = 0; i < approach.size(); ++i) {
    sample.approach[static_cast<Eigen::Index>(i)] = approach[i];
  }
  sample.plunger_force_n.assign(dials, 0.0);
  sample.plunger_force_sd_n.assign(dials, 0.0);
  sample.plunger_direction.assign(dials, 0.0);
  sample.previous_mm.assign(dials, std::nan(""));
  simulation::Weight(model.robot(), model.parameters()).take(q, assembly, sample);
  return pose;
}

tl::expected<Pose<double>, KinematicTrouble> tool_pose(
    const ExportedModel& model, const ModelPose& pose) {
  return ToolOf(model).at(pose);
}

MissBetween miss_between(const ExportedModel& full, const ExportedModel& held) {
  ToolOf one(full);
  ToolOf other(held);
  return summed(full.poses, [&](const ModelPose& pose) -> std::optional<double> {
    const auto a = one.at(pose);
    const auto b = other.at(pose);
    if (!a || !b) return std::nullopt;
    return (a->p - b->p).norm();
  });
}

MissBetween learned_part(const ExportedModel& model) {
  if (!model.learned) return {};
  return summed(model.poses, [&](const ModelPose& pose) -> std::optional<double> {
    return model.learned(pose.q).norm();
  });
}

}  // namespace sixdial::studies
