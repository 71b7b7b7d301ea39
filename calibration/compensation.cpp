#include "calibration/compensation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "geometry/lever.h"
#include "geometry/rotation.h"
#include "geometry/tool_turn.h"
#include "geometry/units.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::JointInfo;
using geometry::JointKind;
using geometry::kUsualLever_mm;
using geometry::Position;

// Half a step of the correction's slope by differences: of a smooth learned function.
constexpr double kSlopeStep_rad = 1e-5;
constexpr double kSlopeStep_mm = 1e-3;
constexpr int kHalvings = 30;

tl::unexpected<CompensationTrouble> trouble(
    CompensationTrouble::Kind kind, const ToolTarget& target, std::string_view why) {
  return tl::unexpected(CompensationTrouble{
      kind, fmt::format(
                "({:.3f}) mm{}: {}", fmt::join(target.p_mm, ", "),
                target.R ? ", turned as asked" : "", why)});
}

/// "working mode ++"; nothing of a robot with one mode.
std::string mode_in_words(const geometry::RobotModel& robot, geometry::WorkingMode mode) {
  if (robot.modes.size() < 2) return "";
  for (const geometry::BranchInfo& each : robot.modes) {
    if (each.number == mode.number) return " in working mode " + each.name;
  }
  return "";
}

MatrixXd slope(
    const Correction& correction, const geometry::RobotModel& robot, Eigen::Index rows,
    const VectorXd& q) {
  MatrixXd result = MatrixXd::Zero(rows, q.size());
  if (!correction) return result;
  for (Eigen::Index joint = 0; joint < q.size(); ++joint) {
    const JointInfo& info = robot.joints[static_cast<std::size_t>(joint)];
    const double size = info.kind == JointKind::kRevolute ? kSlopeStep_rad : kSlopeStep_mm;
    const VectorXd step = size * VectorXd::Unit(q.size(), joint);
    result.col(joint) = (correction(q + step) - correction(q - step)) / (2 * size);
  }
  return result;
}

/// The joint step that moves the tool by `move`; of a robot with more joints than coordinates
/// the shortest one.
VectorXd step_for(const MatrixXd& J, const VectorXd& move) {
  if (J.rows() == J.cols()) return J.fullPivLu().solve(move);
  return J.completeOrthogonalDecomposition().solve(move);
}

/// The joint that is furthest from where the nominal robot would be sent, in words; empty: none
/// is too far.
std::string too_far(
    const geometry::RobotModel& robot, const Compensation& found,
    const CompensationSettings& settings) {
  double most = 1.0;  // in times of what is allowed
  std::string words;
  for (Eigen::Index i = 0; i < found.q.size(); ++i) {
    const JointInfo& joint = robot.joints[static_cast<std::size_t>(i)];
    const bool turns = joint.kind == JointKind::kRevolute;
    const double change = std::abs(found.q[i] - found.nominal_q[i]);
    const double times = change / (turns ? settings.most_change_rad : settings.most_change_mm);
    if (!(times > most)) continue;
    most = times;
    words = fmt::format("{:.3f} {}", change, joint.unit());
  }
  return words;
}

/// How far the joint that moved most has moved, in its unit.
std::string most_moved(const geometry::RobotModel& robot, const Compensation& found) {
  Eigen::Index most = 0;
  const double change = (found.q - found.nominal_q).cwiseAbs().maxCoeff(&most);
  return fmt::format("{:.3f} {}", change, robot.joints[static_cast<std::size_t>(most)].unit());
}

/// What is missing to a target [mm], and below it, where it asks for a turn, the rotation
/// vector that is missing at the end of a lever.
tl::expected<VectorXd, geometry::KinematicTrouble> missing_at(
    const CompensationModel& model, const ToolTarget& target, const VectorXd& q,
    geometry::Assembly assembly) {
  const auto position = modelled_position(model, q, assembly);
  if (!position) return tl::unexpected(position.error());
  const VectorXd way = target.p_mm - *position;
  if (!target.R) return way;
  const auto turned = modelled_turn(model, q, assembly);
  if (!turned) return tl::unexpected(turned.error());
  VectorXd both(way.size() + 3);
  both << way, kUsualLever_mm * geometry::rotation_vector(*target.R * turned->transpose());
  return both;
}

/// Derivative by the joints of what missing_at is the lack of.
tl::expected<MatrixXd, geometry::KinematicTrouble> slope_at(
    const CompensationModel& model, const ToolTarget& target, const VectorXd& q,
    geometry::Assembly assembly) {
  const geometry::RobotModel& robot = model.tool.robot();
  const auto here = model.tool.derivative(model.v, q, assembly);
  if (!here) return tl::unexpected(here.error());
  const MatrixXd J = here->J_q + slope(model.correction, robot, model.tool.axes(), q);
  if (!target.R) return J;
  geometry::Frames at(robot);
  at.tool_only = true;
  if (const auto reached = robot.forward_derivative(model.v, q, assembly, at); !reached) {
    return tl::unexpected(reached.error());
  }
  MatrixXd both(J.rows() + 3, J.cols());
  both << J,
      kUsualLever_mm * (at.by_q[0].bottomRows<3>() + slope(model.turn_correction, robot, 3, q));
  return both;
}

void set_closure(const VectorXd& missing, Eigen::Index axes, Compensation& result) {
  result.closure_mm = missing.head(axes).norm();
  result.closure_rad = missing.tail(missing.size() - axes).norm() / kUsualLever_mm;
}

/// What is left of the way: "3.4e+00 mm", "3.4e+00 mm and 1.2e-01 deg".
std::string left_in_words(const ToolTarget& target, const Compensation& found) {
  std::string words = fmt::format("{:.1e} mm", found.closure_mm);
  if (target.R)
    words += fmt::format(" and {:.1e} deg", geometry::kDegPerRad * found.closure_rad);
  return words;
}

/// Damped Newton from `result` on until the tool is at the target.
tl::expected<Compensation, CompensationTrouble> closed(
    const CompensationModel& model, const ToolTarget& target, geometry::Assembly assembly,
    Compensation result, const CompensationSettings& settings) {
  using Kind = CompensationTrouble::Kind;
  auto missing = missing_at(model, target, result.q, assembly);
  if (!missing) return trouble(Kind::kUnreachable, target, describe(missing.error()));
  const Eigen::Index axes = target.p_mm.size();
  set_closure(*missing, axes, result);
  while (!(
      result.closure_mm <= settings.closure_mm && result.closure_rad <= settings.closure_rad)) {
    if (++result.iterations > settings.max_iterations) {
      return trouble(
          Kind::kNotConverged, target,
          fmt::format(
              "{} steps leave {}", settings.max_iterations, left_in_words(target, result)));
    }
    const auto J = slope_at(model, target, result.q, assembly);
    if (!J) return trouble(Kind::kUnreachable, target, describe(J.error()));
    const VectorXd step = step_for(*J, *missing);
    bool better = false;
    double share = 1.0;
    for (int halving = 0; halving <= kHalvings && !better; ++halving, share /= 2) {
      const VectorXd q = result.q + share * step;
      auto there = missing_at(model, target, q, assembly);
      if (!there || !(there->norm() < missing->norm())) continue;
      better = true;
      result.q = q;
      missing = std::move(there);
      set_closure(*missing, axes, result);
    }
    if (!better) {
      return trouble(
          Kind::kNotConverged, target,
          fmt::format("no step improves on {}", left_in_words(target, result)));
    }
  }
  return result;
}

}  // namespace

ToolTarget CompensationModel::in_frame(const ToolTarget& target) const {
  ToolTarget there{in_frame(target.p_mm), target.R};
  if (frame && there.R) there.R = frame->R * *target.R;
  return there;
}

std::optional<VectorXd> CompensationModel::turn_in(
    geometry::WorkingMode mode, const std::optional<VectorXd>& near) const {
  const auto measured = measured_at.find(mode.number);
  if (measured == measured_at.end()) return near;
  if (!near || tool.axes() != 3 || near->size() != measured->second.size()) {
    return measured->second;
  }
  constexpr double kTurn_rad = 2.0 * std::numbers::pi;
  VectorXd on_turn = *near;
  for (Eigen::Index i = 0; i < on_turn.size(); ++i) {
    const JointInfo& joint = tool.robot().joints[static_cast<std::size_t>(i)];
    if (joint.kind != JointKind::kRevolute || joint.geared) continue;
    on_turn[i] += kTurn_rad * std::round((measured->second[i] - on_turn[i]) / kTurn_rad);
  }
  return on_turn;
}

tl::expected<Position, geometry::KinematicTrouble> modelled_position(
    const CompensationModel& model, const VectorXd& q, geometry::Assembly assembly) {
  return model.tool.position(model.v, q, assembly).map([&](const Position& p_WE) {
    return model.correction ? Position(p_WE + model.correction(q)) : p_WE;
  });
}

tl::expected<Eigen::Matrix3d, geometry::KinematicTrouble> modelled_turn(
    const CompensationModel& model, const VectorXd& q, geometry::Assembly assembly) {
  const auto R = geometry::turn_of_tool(model.tool.robot(), model.v, q, assembly);
  if (!R || !model.turn_correction) return R;
  const Eigen::Vector3d w = model.turn_correction(q);
  return Eigen::Matrix3d(geometry::turned_by<double>(w) * *R);
}

tl::expected<VectorXd, geometry::KinematicTrouble> joints_for(
    const geometry::Tool& tool, const VectorXd& v, const ToolTarget& target,
    geometry::WorkingMode mode, const std::optional<VectorXd>& near) {
  if (!target.R) return tool.inverse(v, target.p_mm, mode, near);
  geometry::Pose<double> X_WE;
  X_WE.p.head(target.p_mm.size()) = target.p_mm;
  X_WE.R = *target.R;
  return geometry::joints_for_pose(tool.robot(), v, X_WE, mode, near);
}

tl::expected<Compensation, CompensationTrouble> compensate(
    const CompensationModel& model, const ToolTarget& asked, geometry::WorkingMode mode,
    const std::optional<VectorXd>& near, const CompensationSettings& settings) {
  using Kind = CompensationTrouble::Kind;
  const geometry::Tool& tool = model.tool;
  if (asked.R && !geometry::reaches_any_turn(tool.robot(), model.nominal)) {
    return trouble(Kind::kNoSuchTurn, asked, "this robot cannot turn its tool any way");
  }
  const ToolTarget target = model.in_frame(asked);
  const auto nominal = joints_for(tool, model.nominal, target, mode, model.turn_in(mode, near));
  if (!nominal) {
    return trouble(
        Kind::kNominalUnreachable, asked,
        fmt::format(
            "by the nominal parameters{}, {}", mode_in_words(tool.robot(), mode),
            describe(nominal.error())));
  }
  const auto start = joints_for(tool, model.v, target, mode, *nominal);
  if (!start) {
    return trouble(
        Kind::kUnreachable, asked,
        fmt::format("by the identified parameters, {}", describe(start.error())));
  }
  const auto assembly = tool.assembly_at(model.v, *start, target.p_mm);
  if (!assembly) return trouble(Kind::kUnreachable, asked, describe(assembly.error()));
  auto result = closed(model, target, *assembly, {*start, *nominal, 0.0, 0}, settings);
  if (!result) return result;
  const auto found = tool.mode_of(model.v, result->q, *assembly);
  const bool in_mode = found && *found == mode;
  const std::string far = too_far(tool.robot(), *result, settings);
  if (!in_mode || !far.empty()) {
    return trouble(
        Kind::kOffBranch, asked,
        fmt::format(
            "the solution is {} from the nominal joint values{}",
            far.empty() ? most_moved(tool.robot(), *result) : far,
            in_mode ? "" : ", in another working mode"));
  }
  return result;
}

tl::expected<Compensation, CompensationTrouble> compensate(
    const CompensationModel& model, const Position& target_mm, geometry::WorkingMode mode,
    const std::optional<VectorXd>& near, const CompensationSettings& settings) {
  return compensate(model, ToolTarget{target_mm}, mode, near, settings);
}

}  // namespace sixdial::calibration
