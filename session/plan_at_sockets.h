// Poses of an arm that put a ball on its tool into a socket, turned in many ways.
//
//        | axis of the socket
//    \   |
//     \  |   stem: from the tool's flange to the ball, leans off the axis by at most the cone
//      \ |
//      (o)   ball, its centre at the socket's place
//     \___/
#pragma once

#include <Eigen/Core>

#include "session/plan_in_space.h"

namespace sixdial::session {

/// How a ball may come into a socket.
struct SeatRule {
  Eigen::Vector3d axis{0, 0, 1};  // of the socket, out of it, in W
  Eigen::Vector3d stem{0, 0, 1};  // towards the ball, in the tool's frame
  double cone_rad = 0.0;          // between the stem and the axis, at most
};

/// Angle between the stem and the socket's axis [rad], the tool turned as R_WE: 0 straight from
/// above.
[[nodiscard]] double lean_of(const SeatRule& rule, const Eigen::Matrix3d& R_WE);

/// Up to `count` poses with the ball's centre at `at_mm` (W): reached from drawn joint values,
/// each turned as it comes from there, within the cone and the ranges of the joints. Left out
/// is what lies so near a singular pose that a straight move into the socket takes more than
/// kMostTravel times the joint travel that a lever as long as the arm needs. Refused, with what
/// stands in the way, where no such pose is found; the robot works in space and lists its
/// joints.
[[nodiscard]] tl::expected<DrawnPoses, PlanRefusal> drawn_at_socket(
    const geometry::Rig& rig, const Eigen::Vector3d& at_mm, const SeatRule& rule, int count,
    Uniform& random);
inline constexpr double kMostTravel = 10.0;

}  // namespace sixdial::session
