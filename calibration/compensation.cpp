#include "calibration/compensation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::JointInfo;
using geometry::JointKind;
using geometry::Position;

// Half a step of the correction's slope by differences: of a smooth learned function.
constexpr double kSlopeStep_rad = 1e-5;
constexpr double kSlopeStep_mm = 1e-3;
constexpr int kHalvings = 30;

tl::unexpected<CompensationTrouble> trouble(
    CompensationTrouble::Kind kind, const Position& target, std::string_view why) {
  return tl::unexpected(
      CompensationTrouble{kind, fmt::format("({:.3f}) mm: {}", fmt::join(target, ", "), why)});
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
    const Correction& correction, const geometry::RobotModel& robot, int axes,
    const VectorXd& q) {
  MatrixXd result = MatrixXd::Zero(axes, q.size());
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

/// Damped Newton from `result` on until the tool is at the target.
tl::expected<Compensation, CompensationTrouble> closed(
    const CompensationModel& model, const Position& target_mm, geometry::Assembly assembly,
    Compensation result, const CompensationSettings& settings) {
  using Kind = CompensationTrouble::Kind;
  auto position = modelled_position(model, result.q, assembly);
  if (!position) return trouble(Kind::kUnreachable, target_mm, describe(position.error()));
  result.closure_mm = (*position - target_mm).norm();
  while (!(result.closure_mm <= settings.closure_mm)) {
    if (++result.iterations > settings.max_iterations) {
      return trouble(
          Kind::kNotConverged, target_mm,
          fmt::format("{} steps leave {:.1e} mm", settings.max_iterations, result.closure_mm));
    }
    const auto here = model.tool.derivative(model.v, result.q, assembly);
    if (!here) return trouble(Kind::kUnreachable, target_mm, describe(here.error()));
    const MatrixXd J =
        here->J_q + slope(model.correction, model.tool.robot(), model.tool.axes(), result.q);
    const VectorXd step = step_for(J, target_mm - *position);
    bool better = false;
    double share = 1.0;
    for (int halving = 0; halving <= kHalvings && !better; ++halving, share /= 2) {
      const VectorXd q = result.q + share * step;
      const auto there = modelled_position(model, q, assembly);
      const double closure_mm = there ? (*there - target_mm).norm() : result.closure_mm;
      if (!(closure_mm < result.closure_mm)) continue;
      better = true;
      result.q = q;
      result.closure_mm = closure_mm;
      position = there;
    }
    if (!better) {
      return trouble(
          Kind::kNotConverged, target_mm,
          fmt::format("no step improves on {:.1e} mm", result.closure_mm));
    }
  }
  return result;
}

}  // namespace

tl::expected<Position, geometry::KinematicTrouble> modelled_position(
    const CompensationModel& model, const VectorXd& q, geometry::Assembly assembly) {
  return model.tool.position(model.v, q, assembly).map([&](const Position& p_WE) {
    return model.correction ? Position(p_WE + model.correction(q)) : p_WE;
  });
}

tl::expected<Compensation, CompensationTrouble> compensate(
    const CompensationModel& model, const Position& asked_mm, geometry::WorkingMode mode,
    const std::optional<VectorXd>& near, const CompensationSettings& settings) {
  using Kind = CompensationTrouble::Kind;
  const geometry::Tool& tool = model.tool;
  const Position target_mm = model.in_frame(asked_mm);
  const auto nominal = tool.inverse(model.nominal, target_mm, mode, model.turn_in(mode, near));
  if (!nominal) {
    return trouble(
        Kind::kNominalUnreachable, asked_mm,
        fmt::format(
            "by the nominal parameters{}, {}", mode_in_words(tool.robot(), mode),
            describe(nominal.error())));
  }
  const auto start = tool.inverse(model.v, target_mm, mode, *nominal);
  if (!start) {
    return trouble(
        Kind::kUnreachable, asked_mm,
        fmt::format("by the identified parameters, {}", describe(start.error())));
  }
  const auto assembly = tool.assembly_at(model.v, *start, target_mm);
  if (!assembly) return trouble(Kind::kUnreachable, asked_mm, describe(assembly.error()));
  auto result = closed(model, target_mm, *assembly, {*start, *nominal, 0.0, 0}, settings);
  if (!result) return result;
  const auto found = tool.mode_of(model.v, result->q, *assembly);
  const bool in_mode = found && *found == mode;
  const std::string far = too_far(tool.robot(), *result, settings);
  if (!in_mode || !far.empty()) {
    return trouble(
        Kind::kOffBranch, asked_mm,
        fmt::format(
            "the solution is {} from the nominal joint values{}",
            far.empty() ? most_moved(tool.robot(), *result) : far,
            in_mode ? "" : ", in another working mode"));
  }
  return result;
}

}  // namespace sixdial::calibration
