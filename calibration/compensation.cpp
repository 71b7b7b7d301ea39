#include "calibration/compensation.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

namespace sixdial::calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Half a step of the correction's slope by differences: of a smooth learned function.
constexpr double kSlopeStep_rad = 1e-5;
constexpr int kHalvings = 30;

tl::unexpected<CompensationTrouble> trouble(
    CompensationTrouble::Kind kind, const Vector2d& target, std::string_view why) {
  return tl::unexpected(CompensationTrouble{
      kind, fmt::format("({:.3f}, {:.3f}) mm: {}", target.x(), target.y(), why)});
}

Matrix2d slope(const Correction& correction, const Vector2d& q) {
  Matrix2d result = Matrix2d::Zero();
  if (!correction) return result;
  for (int joint = 0; joint < 2; ++joint) {
    const Vector2d step = kSlopeStep_rad * Vector2d::Unit(joint);
    result.col(joint) = (correction(q + step) - correction(q - step)) / (2 * kSlopeStep_rad);
  }
  return result;
}

}  // namespace

tl::expected<Vector2d, geometry::KinematicTrouble> modelled_position(
    const CompensationModel& model, const Vector2d& q_rad, geometry::Assembly assembly) {
  return geometry::forward(model.v, q_rad, assembly)
      .map([&](const geometry::ForwardPose& pose) -> Vector2d {
        return model.correction ? Vector2d(pose.p_WE + model.correction(q_rad)) : pose.p_WE;
      });
}

tl::expected<Compensation, CompensationTrouble> compensate(
    const CompensationModel& model, const Vector2d& target_mm, geometry::WorkingMode mode,
    std::optional<Vector2d> near, const CompensationSettings& settings) {
  using Kind = CompensationTrouble::Kind;
  const auto nominal = geometry::inverse(model.nominal, target_mm, mode, near);
  if (!nominal) {
    return trouble(
        Kind::kNominalUnreachable, target_mm,
        fmt::format(
            "by the nominal parameters in working mode {}, {}", geometry::to_string(mode),
            describe(nominal.error())));
  }
  const auto start = geometry::inverse(model.v, target_mm, mode, *nominal);
  if (!start) {
    return trouble(
        Kind::kUnreachable, target_mm,
        fmt::format("by the identified parameters, {}", describe(start.error())));
  }
  const auto assembly = geometry::assembly_at(model.v, *start, target_mm);
  if (!assembly) return trouble(Kind::kUnreachable, target_mm, describe(assembly.error()));

  Compensation result{*start, *nominal, 0.0, 0};
  auto position = modelled_position(model, result.q_rad, *assembly);
  if (!position) return trouble(Kind::kUnreachable, target_mm, describe(position.error()));
  result.closure_mm = (*position - target_mm).norm();
  while (!(result.closure_mm <= settings.closure_mm)) {
    if (++result.iterations > settings.max_iterations) {
      return trouble(
          Kind::kNotConverged, target_mm,
          fmt::format("{} steps leave {:.1e} mm", settings.max_iterations, result.closure_mm));
    }
    const auto here = geometry::forward_derivative(model.v, result.q_rad, *assembly);
    if (!here) return trouble(Kind::kUnreachable, target_mm, describe(here.error()));
    const Matrix2d J = here->J_q + slope(model.correction, result.q_rad);
    const Vector2d step = J.fullPivLu().solve(target_mm - *position);
    bool better = false;
    double share = 1.0;
    for (int halving = 0; halving <= kHalvings && !better; ++halving, share /= 2) {
      const Vector2d q = result.q_rad + share * step;
      const auto there = modelled_position(model, q, *assembly);
      const double closure_mm = there ? (*there - target_mm).norm() : result.closure_mm;
      if (!(closure_mm < result.closure_mm)) continue;
      better = true;
      result.q_rad = q;
      result.closure_mm = closure_mm;
      position = there;
    }
    if (!better) {
      return trouble(
          Kind::kNotConverged, target_mm,
          fmt::format("no step improves on {:.1e} mm", result.closure_mm));
    }
  }
  const auto found = geometry::working_mode_of(model.v, result.q_rad, *assembly);
  const double change_rad = (result.q_rad - result.nominal_q_rad).cwiseAbs().maxCoeff();
  if (!found || *found != mode || change_rad > settings.most_change_rad) {
    return trouble(
        Kind::kOffBranch, target_mm,
        fmt::format(
            "the solution is {:.3f} rad from the nominal angles{}", change_rad,
            found && *found == mode ? "" : ", in another working mode"));
  }
  return result;
}

}  // namespace sixdial::calibration
