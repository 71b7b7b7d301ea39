#include "geometry/five_bar.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/units.h"

namespace sixdial::geometry {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAngle_rad = 1.0 / 60.0;  // moves the end of a 60 mm link by one millimetre

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }
Vector2d turned_left(const Vector2d& a) { return {-a.y(), a.x()}; }

bool usable(const ParameterVector& v) { return v.allFinite() && v.head<4>().minCoeff() > 0.0; }

struct Closure {  // all in frame B
  Vector2d p_O3, p_O4, p_E;
};

tl::expected<Closure, KinematicTrouble> close_loop(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  if (!usable(v) || !q.allFinite()) return tl::unexpected(KinematicTrouble::kBadParameters);
  const double a1 = q[0] + v[kOffset1];
  const double a2 = q[1] + v[kOffset2];
  const Vector2d p_O3(v[kL11] * std::cos(a1) - v[kD] / 2, v[kL11] * std::sin(a1));  // (4)
  const Vector2d p_O4(v[kL21] * std::cos(a2) + v[kD] / 2, v[kL21] * std::sin(a2));  // (5)
  const Vector2d w = p_O4 - p_O3;
  const double D2 = w.squaredNorm();
  const double la = v[kL12];
  const double lb = v[kL22];
  const double D = std::sqrt(D2);  // (6)
  if (D <= 1e-12 * (la + lb)) return tl::unexpected(KinematicTrouble::kCoincidentElbows);
  // 16 sigma^2 factored so that no digits are lost near stretched and folded (7).
  const double sixteen_sigma2 = (D + la + lb) * (D + la - lb) * (D - la + lb) * (la + lb - D);
  if (sixteen_sigma2 < 0.0) return tl::unexpected(KinematicTrouble::kOutOfReach);
  const double sigma = std::sqrt(sixteen_sigma2) / 4;
  if (2 * sigma < kSingularSine * la * lb) {
    return tl::unexpected(
        D > std::max(la, lb) ? KinematicTrouble::kStretched : KinematicTrouble::kFolded);
  }
  const double beta = static_cast<double>(assembly);
  const Vector2d p_E = (p_O3 + p_O4) / 2 + (la - lb) * (la + lb) / (2 * D2) * w +
                       beta * 2 * sigma / D2 * turned_left(w);  // (3)
  return Closure{p_O3, p_O4, p_E};
}

Matrix2d rotation(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return (Matrix2d() << c, -s, s, c).finished();
}

ForwardPose in_world(const ParameterVector& v, const Closure& closure) {
  const Matrix2d R_WB = rotation(v[kAlpha]);
  const Vector2d p_WB(v[kX0], v[kY0]);
  return {
      p_WB + R_WB * closure.p_E, p_WB + R_WB * closure.p_O3,
      p_WB + R_WB * closure.p_O4};  // (1)
}

}  // namespace

const std::array<ParameterInfo, kParameterCount> kParameters{{
    {"l11", "l11_mm", "mm", 1.0, "mm", 1.0},
    {"l12", "l12_mm", "mm", 1.0, "mm", 1.0},
    {"l21", "l21_mm", "mm", 1.0, "mm", 1.0},
    {"l22", "l22_mm", "mm", 1.0, "mm", 1.0},
    {"d", "d_mm", "mm", 1.0, "mm", 1.0},
    {"x0", "x0_mm", "mm", 1.0, "mm", 1.0},
    {"y0", "y0_mm", "mm", 1.0, "mm", 1.0},
    {"alpha", "alpha_deg", "deg", kDegPerRad, "rad", kAngle_rad},
    {"dtheta1", "theta1_offset_deg", "deg", kDegPerRad, "rad", kAngle_rad},
    {"dtheta2", "theta2_offset_deg", "deg", kDegPerRad, "rad", kAngle_rad},
}};

std::string to_string(WorkingMode mode) {
  return {mode.leg1 > 0 ? '+' : '-', mode.leg2 > 0 ? '+' : '-'};
}

std::optional<WorkingMode> working_mode_from(std::string_view text) {
  for (const WorkingMode mode : kWorkingModes) {
    if (to_string(mode) == text) return mode;
  }
  return std::nullopt;
}

std::string_view describe(KinematicTrouble trouble) {
  switch (trouble) {
    case KinematicTrouble::kOutOfReach:
      return "the legs cannot reach this pose";
    case KinematicTrouble::kStretched:
      return "a leg is stretched straight there (singular)";
    case KinematicTrouble::kFolded:
      return "a leg is folded onto itself there (singular)";
    case KinematicTrouble::kCoincidentElbows:
      return "both elbows coincide there, so the tool is not determined";
    case KinematicTrouble::kBadParameters:
      return "a length is not positive or a number is not finite";
  }
  return "unknown kinematic trouble";
}

double ForwardPose::distal_angle(int leg) const {
  const Vector2d u = p_WE - (leg == 0 ? p_WO3 : p_WO4);
  return std::atan2(u.y(), u.x());
}

tl::expected<ForwardPose, KinematicTrouble> forward(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  return close_loop(v, q, assembly).map([&](const Closure& c) { return in_world(v, c); });
}

tl::expected<ForwardDerivative, KinematicTrouble> forward_derivative(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  const auto closure = close_loop(v, q, assembly);
  if (!closure) return tl::unexpected(closure.error());
  const auto& [p_O3, p_O4, p_E] = *closure;
  const Vector2d u1 = p_E - p_O3;
  const Vector2d u2 = p_E - p_O4;
  const Vector2d unit1 = turned_left(p_O3 + Vector2d(v[kD] / 2, 0.0));  // dO3/dtheta1
  const Vector2d unit2 = turned_left(p_O4 - Vector2d(v[kD] / 2, 0.0));  // dO4/dtheta2

  // Differentiating (2): u1'(dE - dO3) = l12 dl12, u2'(dE - dO4) = l22 dl22.
  const double det = cross(u1, u2);
  Matrix2d A_inverse;
  A_inverse << u2.y(), -u1.y(), -u2.x(), u1.x();
  A_inverse /= det;

  Eigen::Matrix<double, 2, kParameterCount> dO3 = decltype(dO3)::Zero();
  Eigen::Matrix<double, 2, kParameterCount> dO4 = decltype(dO4)::Zero();
  dO3.col(kL11) = (p_O3 + Vector2d(v[kD] / 2, 0.0)) / v[kL11];
  dO3.col(kD) = Vector2d(-0.5, 0.0);
  dO3.col(kOffset1) = unit1;
  dO4.col(kL21) = (p_O4 - Vector2d(v[kD] / 2, 0.0)) / v[kL21];
  dO4.col(kD) = Vector2d(0.5, 0.0);
  dO4.col(kOffset2) = unit2;
  Eigen::Matrix<double, 2, kParameterCount> right;
  right.row(0) = u1.transpose() * dO3;
  right.row(1) = u2.transpose() * dO4;
  right(0, kL12) += v[kL12];
  right(1, kL22) += v[kL22];
  const ParameterJacobian dE = A_inverse * right;

  ForwardDerivative result;
  result.pose = in_world(v, *closure);
  const Matrix2d R_WB = rotation(v[kAlpha]);
  result.J_v = R_WB * dE;
  result.J_v(0, kX0) = 1.0;
  result.J_v(1, kY0) = 1.0;
  result.J_v.col(kAlpha) = turned_left(R_WB * p_E);
  result.J_q << result.J_v.col(kOffset1), result.J_v.col(kOffset2);

  // Angle of u: d(atan2) = cross(u, du) / |u|^2; alpha turns both.
  result.distal_J_v.row(0) =
      (u1.x() * (dE - dO3).row(1) - u1.y() * (dE - dO3).row(0)) / u1.squaredNorm();
  result.distal_J_v.row(1) =
      (u2.x() * (dE - dO4).row(1) - u2.y() * (dE - dO4).row(0)) / u2.squaredNorm();
  result.distal_J_v.col(kAlpha).setOnes();
  result.distal_J_q << result.distal_J_v.col(kOffset1), result.distal_J_v.col(kOffset2);
  return result;
}

tl::expected<Vector2d, KinematicTrouble> inverse(
    const ParameterVector& v, const Vector2d& p_WE, WorkingMode mode,
    std::optional<Vector2d> near) {
  if (!usable(v) || !p_WE.allFinite()) return tl::unexpected(KinematicTrouble::kBadParameters);
  const Vector2d p_BE = rotation(-v[kAlpha]) * (p_WE - Vector2d(v[kX0], v[kY0]));
  Vector2d q;
  for (int leg = 0; leg < 2; ++leg) {
    const double la = leg == 0 ? v[kL11] : v[kL21];
    const double lb = leg == 0 ? v[kL12] : v[kL22];
    const double base_x = (leg == 0 ? -0.5 : 0.5) * v[kD];
    const Vector2d to_E = p_BE - Vector2d(base_x, 0.0);
    const double r = to_E.norm();
    const double sixteen_sigma2 = (r + la + lb) * (r + la - lb) * (r - la + lb) * (la + lb - r);
    if (sixteen_sigma2 < 0.0) return tl::unexpected(KinematicTrouble::kOutOfReach);
    const double twice_sigma = std::sqrt(sixteen_sigma2) / 2;
    if (twice_sigma < kSingularSine * la * lb) {
      return tl::unexpected(
          r > std::max(la, lb) ? KinematicTrouble::kStretched : KinematicTrouble::kFolded);
    }
    // acos((la^2 + r^2 - lb^2)/(2 la r)) as an atan2, which keeps its digits near 0 and pi.
    const double inner = std::atan2(twice_sigma, (la * la + r * r - lb * lb) / 2);
    const double side = leg == 0 ? mode.leg1 : mode.leg2;
    double angle = std::atan2(to_E.y(), to_E.x()) + side * inner;
    angle = std::remainder(angle, 2 * std::numbers::pi) - v[kOffset1 + leg];
    if (near) {
      angle +=
          2 * std::numbers::pi * std::round(((*near)[leg] - angle) / (2 * std::numbers::pi));
    }
    q[leg] = angle;
  }
  return q;
}

tl::expected<Assembly, KinematicTrouble> assembly_at(
    const ParameterVector& v, const Vector2d& q, const Vector2d& p_WE) {
  const auto left = forward(v, q, Assembly::kLeft);
  if (!left) return tl::unexpected(left.error());
  const auto right = forward(v, q, Assembly::kRight);
  if (!right) return tl::unexpected(right.error());
  return (left->p_WE - p_WE).squaredNorm() <= (right->p_WE - p_WE).squaredNorm()
             ? Assembly::kLeft
             : Assembly::kRight;
}

tl::expected<WorkingMode, KinematicTrouble> working_mode_of(
    const ParameterVector& v, const Vector2d& q, Assembly assembly) {
  const auto closure = close_loop(v, q, assembly);
  if (!closure) return tl::unexpected(closure.error());
  const Vector2d half_base(v[kD] / 2, 0.0);
  const double side1 = cross(closure->p_E + half_base, closure->p_O3 + half_base);
  const double side2 = cross(closure->p_E - half_base, closure->p_O4 - half_base);
  return WorkingMode{side1 >= 0 ? +1 : -1, side2 >= 0 ? +1 : -1};
}

}  // namespace sixdial::geometry
