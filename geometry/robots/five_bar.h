// A planar five-bar's tool from its motor angles and back, equations (1)-(7) of Cao et al.
// 2021.
//
//            E            tool            E = p_W0 + R(alpha) p_BE                        (1)
//     l12  /   \  l22     distal links    |E - O3| = l12, |E - O4| = l22                  (2)
//        O3     O4        elbows          frame B: origin midway between O1 and O2, Bx O1 -> O2
//     l11 |     | l21     proximal links  frame W: the table; B is at (x0, y0), turned by alpha
//        O1--B--O2        motors, d apart
//
// Millimetres and radians; angles counter-clockwise and continuous (never wrapped at +-pi).
// Degenerate: out of reach, stretched or folded legs, coincident elbows (D = 0). Coaxial motors
// (d = 0) are a robot like any other, and d may be negative: O2 left of O1, so that an estimate
// of d around 0 is free on both sides. Each degenerate case is named, none returns NaN.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

inline constexpr int kParameterCount = 10;

/// The ten parameters in the order of equation (8): l11, l12, l21, l22, d, x0 and y0 [mm],
/// alpha, dtheta1, dtheta2 [rad].
using ParameterVector = Eigen::Matrix<double, kParameterCount, 1>;
using ParameterMatrix = Eigen::Matrix<double, kParameterCount, kParameterCount>;
/// d(p_WE)/d(parameters), 2x10 [mm/mm and mm/rad].
using ParameterJacobian = Eigen::Matrix<double, 2, kParameterCount>;

enum ParameterIndex : int { kL11, kL12, kL21, kL22, kD, kX0, kY0, kAlpha, kOffset1, kOffset2 };

extern const std::array<ParameterInfo, kParameterCount> kParameters;

inline constexpr std::array<WorkingMode, 4> kWorkingModes{
    WorkingMode{+1, +1}, WorkingMode{+1, -1}, WorkingMode{-1, +1}, WorkingMode{-1, -1}};
/// "++", "+-", "-+", "--".
[[nodiscard]] std::string to_string(WorkingMode mode);
[[nodiscard]] std::optional<WorkingMode> working_mode_from(std::string_view text);

/// Poses closer to stretched or folded than this are refused: sine of the angle between the two
/// links of a dyad (1e-7 keeps a derivative meaningful to 1e-9 relative).
inline constexpr double kSingularSine = 1e-7;

struct ForwardPose {
  Eigen::Vector2d p_WE;   // tool
  Eigen::Vector2d p_WO3;  // elbow of leg 1
  Eigen::Vector2d p_WO4;  // elbow of leg 2
  /// Angle of the distal link O3->E (leg 0) or O4->E (leg 1) in W [rad], in (-pi, pi].
  [[nodiscard]] double distal_angle(int leg) const;
};

/// Equations (1)-(7). q: encoder angles theta1, theta2 [rad], 2x1.
[[nodiscard]] tl::expected<ForwardPose, KinematicTrouble> forward(
    const ParameterVector& v, const Eigen::Vector2d& q, Assembly assembly);

struct ForwardDerivative {
  ForwardPose pose;
  ParameterJacobian J_v;  // dp_WE/dv, equation (13)
  Eigen::Matrix2d J_q;    // dp_WE/dq [mm/rad]
  /// d(distal angle in W)/dv of leg 0 and 1, 2x10, and by q, 2x2.
  Eigen::Matrix<double, 2, kParameterCount> distal_J_v;
  Eigen::Matrix2d distal_J_q;
};
[[nodiscard]] tl::expected<ForwardDerivative, KinematicTrouble> forward_derivative(
    const ParameterVector& v, const Eigen::Vector2d& q, Assembly assembly);

/// Encoder angles [rad] that put the tool at p_WE [mm] in a working mode. Each angle is the
/// branch nearest to `near` (default: in (-pi, pi] minus the offset).
[[nodiscard]] tl::expected<Eigen::Vector2d, KinematicTrouble> inverse(
    const ParameterVector& v, const Eigen::Vector2d& p_WE, WorkingMode mode,
    std::optional<Eigen::Vector2d> near = std::nullopt);

/// The assembly that puts the tool of joint angles q at p_WE; the nearer one if neither does
/// exactly. Fails only where neither assembly has a pose.
[[nodiscard]] tl::expected<Assembly, KinematicTrouble> assembly_at(
    const ParameterVector& v, const Eigen::Vector2d& q, const Eigen::Vector2d& p_WE);

/// The working mode that a pose is in.
[[nodiscard]] tl::expected<WorkingMode, KinematicTrouble> working_mode_of(
    const ParameterVector& v, const Eigen::Vector2d& q, Assembly assembly);

/// The row of the registry, and the one model of this kind.
extern const RobotKind five_bar;
[[nodiscard]] const std::shared_ptr<const RobotModel>& five_bar_model();

}  // namespace sixdial::geometry
