#include "studies/extended_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "diagnosis/joint_fit.h"
#include "geometry/rotation.h"
#include "simulation/weight.h"

namespace sixdial::studies {
namespace {

simulation::ModelVector model_from(const std::vector<double>& values, std::size_t parameters) {
  if (values.size() != parameters) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format(
            "the diagnosis has {} parameters where {} are needed", values.size(), parameters),
        {}, "Diagnose the session again.");
  }
  return Eigen::Map<const simulation::ModelVector>(
      values.data(), static_cast<Eigen::Index>(values.size()));
}

simulation::ActiveEffect effect_from(const FittedEffect& fitted, const geometry::Rig& rig) {
  if (const simulation::Effect* effect = simulation::find_effect(fitted.id.cause)) {
    for (const simulation::Place& place : effect->places(rig)) {
      if (place.name != fitted.id.where) continue;
      const bool whole = effect->is_curve || fitted.x.size() == effect->parameters.size();
      if (whole) return {effect, place, fitted.x};
    }
  }
  throw StudyError(
      StudyErrorCode::kBadData,
      fmt::format(
          "this program does not know the cause {} at {}", fitted.id.cause, fitted.id.where),
      {}, "Diagnose the session again.");
}

/// Parameters of the nominal robot, where the diagnosis had it stand.
Eigen::VectorXd nominal_from(const ExtendedFit& fit, const simulation::ForwardModel& base) {
  const Eigen::Index robot = base.robot_parameter_count();
  if (!fit.nominal || std::ssize(*fit.nominal) != robot) return base.nominal().head(robot);
  return Eigen::Map<const Eigen::VectorXd>(fit.nominal->data(), robot);
}

int sign(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

}  // namespace

ExtendedFit commands_of(const diagnosis::Readings& readings, const diagnosis::JointFit& fit) {
  const simulation::Circumstance& last = readings.circumstances().back();
  ExtendedFit result{
      .model = std::vector<double>(fit.model.begin(), fit.model.end()),
      .last_order = last.order,
      .last_time_h = last.time_h,
      .last_temperature_degC = last.temperature_degC};
  for (const simulation::ActiveEffect& active : fit.effects) {
    result.effects.push_back(
        {.id = {std::string(active.effect->cause), active.place.name}, .x = active.x});
  }
  return result;
}

void check_knows_turns(const ExtendedFit& fit) {
  if (fit.turns.value_or(false)) return;
  throw StudyError(
      StudyErrorCode::kBadData,
      "the target has a turn, and the diagnosis was made without turns of the tool", {},
      "Diagnose a session that has turns of the tool: sixdial diagnose SESSION.");
}

ExtendedCommand::ExtendedCommand(
    const ExtendedFit& fit, const geometry::Rig& rig, CompensateBy by)
    : base_(rig),
      model_(model_from(fit.model, base_.parameters().size())),
      order_(fit.last_order + 1),
      last_time_h_(fit.last_time_h),
      last_temperature_degC_(fit.last_temperature_degC),
      nominal_(nominal_from(fit, base_)),
      measured_at_(middles_of(fit.measured_joints)),
      frame_(fit.frame),
      covariance_(fit.covariance),
      left_sd_mm_(fit.left_sd_mm.value_or(0.0)) {
  axes_ = geometry::Tool(rig).axes();
  for (const FittedEffect& each : fit.effects) effects_.push_back(effect_from(each, rig));
  if (by != CompensateBy::kExtendedFull) return;
  if (!fit.residual_model) {
    throw StudyError(
        StudyErrorCode::kBadData, "the diagnosis has no residual model on top of its causes",
        {},
        "Diagnose the session again with the gain on G2: sixdial diagnose SESSION, without "
        "--no-gain.");
  }
  learned_ = correction_of(*fit.residual_model, "", "Diagnose the session again.");
}

simulation::Circumstance ExtendedCommand::circumstance(
    const CommandMoment& moment, std::vector<double> plunger_force_n) const {
  const std::size_t dials = base_.rig().dials.size();
  simulation::Circumstance result;
  result.order = order_;
  result.time_h = moment.time_h.value_or(last_time_h_);
  result.temperature_degC = moment.temperature_c.value_or(last_temperature_degC_);
  result.approach.setZero(base_.robot().joint_count());
  for (Eigen::Index i = 0; i < result.approach.size(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    if (joint < moment.approach.size()) result.approach[i] = moment.approach[joint];
  }
  result.travel = moment.travel;
  result.plunger_force_n = std::move(plunger_force_n);
  result.plunger_force_sd_n.assign(dials, 0.0);
  for (std::size_t i = 0; i < dials; ++i) {
    result.force_n += result.plunger_force_n[i] * base_.rig().dials[i].geometry.axis;
  }
  result.plunger_direction.assign(dials, 0.0);
  result.previous_mm.assign(dials, std::nan(""));
  return result;
}

std::vector<double> ExtendedCommand::forces_at(
    const Eigen::VectorXd& q, geometry::Assembly assembly) const {
  const auto& dials = base_.rig().dials;
  std::vector<double> force_n(dials.size(), 0.0);
  const auto seen = base_.predict(model_, q, assembly);
  if (!seen) return force_n;
  for (std::size_t i = 0; i < dials.size(); ++i) {
    if (!seen->in_contact[i]) continue;
    const double in_mm = seen->reading[static_cast<Eigen::Index>(i)];
    force_n[i] = dials[i].force_n + dials[i].spring_n_per_mm * in_mm;
  }
  return force_n;
}

ExtendedCommand::ToolPose ExtendedCommand::pose_of(
    const simulation::ModelVector& model, const std::vector<simulation::ActiveEffect>& effects,
    const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const {
  const simulation::ExtendedModel extended(base_, effects);
  simulation::Trial trial;
  trial.q = q;
  trial.assembly = assembly;
  simulation::Scene scene;
  simulation::Circumstance sample = circumstance(moment, forces_at(q, assembly));
  simulation::Weight(base_.robot(), model.head(base_.robot_parameter_count()))
      .take(q, assembly, sample);
  const auto ran = extended.run(model, trial, sample, scene);
  if (!ran) return tl::unexpected(ran.error());
  geometry::Pose<double> X_WE{.p = scene.p_WE};
  if (!scene.X.empty()) X_WE.R = scene.X.front().R;
  return X_WE;
}

ExtendedCommand::ToolPose ExtendedCommand::pose(
    const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const {
  return pose_of(model_, effects_, q, assembly, moment).map([&](geometry::Pose<double> X_WE) {
    if (learned_) X_WE.p.head(axes_) += learned_(q);
    return X_WE;
  });
}

tl::expected<geometry::Position, geometry::KinematicTrouble> ExtendedCommand::position(
    const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const {
  return pose(q, assembly, moment).map([&](const geometry::Pose<double>& X_WE) {
    return geometry::Position(X_WE.p.head(axes_));
  });
}

std::optional<Eigen::MatrixXd> ExtendedCommand::slopes_of(
    const Eigen::VectorXd& q, geometry::Assembly assembly, const CommandMoment& moment) const {
  std::vector<Eigen::VectorXd> columns;
  const auto add = [&](const auto& at, double step) {
    const ToolPose up = at(step);
    const ToolPose down = at(-step);
    if (!up || !down) return false;
    Eigen::VectorXd twist(6);
    twist << up->p - down->p, geometry::rotation_vector(up->R * down->R.transpose());
    columns.push_back(twist / (2.0 * step));
    return true;
  };
  constexpr double kShare = 1e-3;  // of a plausible size
  for (Eigen::Index k = 0; k < model_.size(); ++k) {
    const auto at = [&](double step) {
      simulation::ModelVector moved = model_;
      moved[k] += step;
      return pose_of(moved, effects_, q, assembly, moment);
    };
    if (!add(at, kShare * base_.parameters()[static_cast<std::size_t>(k)].change)) return {};
  }
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const simulation::Effect& effect = *effects_[e].effect;
    for (int i = 0; i < diagnosis::fitted_count(effect); ++i) {
      const auto index = static_cast<std::size_t>(i);
      const auto size = simulation::parameter_at(effect, effects_[e].place, i);
      const auto at = [&](double step) {
        std::vector<simulation::ActiveEffect> moved = effects_;
        moved[e].x[index] += step;
        return pose_of(model_, moved, q, assembly, moment);
      };
      if (!add(at, kShare * (size ? size->sigma : effect.parameters[index].sigma))) return {};
    }
  }
  Eigen::MatrixXd slopes(6, std::ssize(columns));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    slopes.col(static_cast<Eigen::Index>(k)) = columns[k];
  }
  return slopes;
}

std::optional<TargetUncertainty> ExtendedCommand::uncertainty(
    const CommandedTarget& commanded, const CommandMoment& moment) const {
  if (!covariance_ || axes_ != 3) return std::nullopt;
  const geometry::Tool tool(base_.rig().robot.model, axes_);
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(
      commanded.theta_rad.data(), std::ssize(commanded.theta_rad));
  const geometry::Position there =
      frame_ ? geometry::Position((*frame_)(commanded.target_mm)) : commanded.target_mm;
  const auto assembly = tool.assembly_at(model_.head(base_.robot_parameter_count()), q, there);
  const auto slopes = assembly ? slopes_of(q, *assembly, moment) : std::nullopt;
  const bool known = slopes && covariance_->rows() == slopes->cols() &&
                     covariance_->cols() == slopes->cols() && covariance_->allFinite();
  if (!known) return std::nullopt;
  Eigen::MatrixXd twist = *slopes * *covariance_ * slopes->transpose();
  add_smooth_errors(left_sd_mm_, base_.instrument(), twist);
  return uncertainty_of(twist, commanded.turn.has_value());
}

calibration::CompensationModel ExtendedCommand::without_causes() const {
  return {
      .tool = geometry::Tool(base_.rig().robot.model, axes_),
      .nominal = nominal_,
      .v = model_.head(base_.robot_parameter_count()),
      .measured_at = measured_at_,
      .frame = frame_};
}

tl::expected<calibration::Compensation, calibration::CompensationTrouble>
ExtendedCommand::solve(
    const calibration::ToolTarget& target, geometry::WorkingMode mode,
    const CommandMoment& moment, const std::optional<Eigen::VectorXd>& near) const {
  calibration::CompensationModel model = without_causes();
  const calibration::ToolTarget there = model.in_frame(target);
  const auto start =
      calibration::joints_for(model.tool, model.v, there, mode, model.turn_in(mode, near));
  if (!start) return calibration::compensate(model, target, mode, near);  // says why
  const auto assembly = model.tool.assembly_at(model.v, *start, there.p_mm);
  if (!assembly) return calibration::compensate(model, target, mode, near);
  // What the causes add to the plain robot at these angles; nothing where it has no pose.
  model.correction = [this, tool = model.tool, v = model.v, moment,
                      at = *assembly](const Eigen::VectorXd& q) -> Eigen::VectorXd {
    const auto extended = position(q, at, moment);
    const auto plain = tool.position(v, q, at);
    if (!extended || !plain) return Eigen::VectorXd::Zero(axes_);
    return *extended - *plain;
  };
  if (!target.R) return calibration::compensate(model, target, mode, near);
  calibration::CompensationModel plain = model;
  plain.turn_correction = {};
  model.turn_correction = [this, plain, moment,
                           at = *assembly](const Eigen::VectorXd& q) -> Eigen::VectorXd {
    const auto extended = pose(q, at, moment);
    const auto alone = calibration::modelled_turn(plain, q, at);
    if (!extended || !alone) return Eigen::Vector3d::Zero();
    return geometry::rotation_vector(extended->R * alone->transpose());
  };
  return calibration::compensate(model, target, mode, near);
}

tl::expected<calibration::Compensation, calibration::CompensationTrouble>
ExtendedCommand::solve(
    const geometry::Position& target_mm, geometry::WorkingMode mode,
    const CommandMoment& moment, const std::optional<Eigen::VectorXd>& near) const {
  return solve(calibration::ToolTarget{target_mm}, mode, moment, near);
}

tl::expected<calibration::Compensation, calibration::CompensationTrouble>
ExtendedCommand::solve_after(
    const Eigen::VectorXd& previous_q, const calibration::ToolTarget& target,
    geometry::WorkingMode mode, CommandMoment moment,
    const std::optional<Eigen::VectorXd>& near) const {
  const auto joints = static_cast<std::size_t>(base_.robot().joint_count());
  const auto moves = [&](const Eigen::VectorXd& q) {
    std::vector<int> signs;
    for (Eigen::Index i = 0; i < q.size(); ++i) signs.push_back(sign(q[i] - previous_q[i]));
    return signs;
  };
  moment.approach.resize(joints, 0);
  const std::vector<int> asked = moment.approach;
  const auto with = [&](const std::vector<int>& signs) {
    for (std::size_t joint = 0; joint < joints; ++joint) {
      moment.approach[joint] = asked[joint] != 0 ? asked[joint] : signs[joint];
    }
    return solve(target, mode, moment, near);
  };
  // A joint that comes from below stops at the upper of two angles, one that comes from above
  // at the lower: one of all combinations always agrees with its own moves.
  auto found = with(near ? moves(*near) : std::vector<int>(joints, 1));
  const auto agrees = [&] {
    const std::vector<int> now = moves(found->q);
    for (std::size_t joint = 0; joint < joints; ++joint) {
      if (asked[joint] == 0 && now[joint] != moment.approach[joint]) return false;
    }
    return true;
  };
  // All joints from below first, then the last joint from above, and so on.
  for (std::size_t from_above = 0; from_above < (std::size_t{1} << joints); ++from_above) {
    if (!found || agrees()) return found;
    std::vector<int> signs(joints, 1);
    for (std::size_t joint = 0; joint < joints; ++joint) {
      if ((from_above >> (joints - 1 - joint)) % 2 != 0) signs[joint] = -1;
    }
    found = with(signs);
  }
  return found;
}

namespace {

constexpr double kMoves_mm = 1e-6;

/// Direction of the tool's last move to a point, zero: none. Where the plan asks for sides, the
/// joints come from there by a short way (Collector::pre_position).
Eigen::Vector3d last_travel(
    const session::PlanPoint& point, const session::PlanPoint* before,
    const ExtendedCommand& command, const geometry::Rig& rig) {
  const geometry::Tool tool(rig);
  const auto direction = [](const Eigen::VectorXd& way) -> Eigen::Vector3d {
    Eigen::Vector3d result = Eigen::Vector3d::Zero();
    if (way.norm() > kMoves_mm) result.head(way.size()) = way.normalized();
    return result;
  };
  Eigen::VectorXd sides(point.q.size());
  for (Eigen::Index joint = 0; joint < sides.size(); ++joint) {
    sides[joint] = session::approach_of(point, static_cast<std::size_t>(joint));
  }
  if (!sides.isZero()) {
    const auto assembly = tool.assembly_at(rig.robot.nominal, point.q, point.target_mm);
    if (!assembly) return Eigen::Vector3d::Zero();
    const auto slope = tool.derivative(rig.robot.nominal, point.q, *assembly);
    if (!slope) return Eigen::Vector3d::Zero();
    return direction(slope->J_q * sides);
  }
  if (before == nullptr) return Eigen::Vector3d::Zero();
  const auto assembly = tool.assembly_at(rig.robot.nominal, before->q, before->target_mm);
  const auto stood =
      assembly ? command.position(before->q, *assembly, {}) : tl::unexpected(assembly.error());
  return direction(point.target_mm - stood.value_or(geometry::Position(before->target_mm)));
}

}  // namespace

session::Plan extended_plan(
    session::Plan plan, const ExtendedCommand& command, const geometry::Rig& rig,
    const PlanMoment& when) {
  std::string named;
  std::size_t troubles = 0;
  const calibration::CompensationModel alone = command.without_causes();
  const session::PlanPoint* before = nullptr;
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    session::PlanPoint& point = plan.points[i];
    CommandMoment moment{
        .approach = point.approach,
        .travel = last_travel(point, before, command, rig),
        .temperature_c = when.temperature_c};
    if (when.first_time_h) {
      moment.time_h = *when.first_time_h + static_cast<double>(i) * when.hours_a_point;
    }
    const auto mode = mode_of(rig, point.q, point.target_mm);
    const auto near = near_of(point, alone, rig);
    const auto found =
        before == nullptr
            ? command.solve(target_of(point, rig), mode, moment, near)
            : command.solve_after(before->q, target_of(point, rig), mode, moment, near);
    if (found) {
      point.q = found->q;
    } else if (++troubles <= kMostNamed) {
      named += fmt::format(
          "{}{} {}.{} {}", named.empty() ? "" : "; ", point.set, point.point, point.repeat,
          found.error().message);
    }
    before = &point;
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
