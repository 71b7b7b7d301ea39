// A true arm with a ball on its tool that somebody leads by hand from socket to socket: its
// lengths, angles and zeros are not quite those of its rig file. Millimetre and radian.
//
// Example:
//   const ArmWorld world = arm_of_rig(rig, 7);
//   const auto q = seated(world, rig, {{"S1", q_planned}});  // what the encoders read
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/rig.h"
#include "mock_devices/arm_world.h"

namespace sixdial::mock_devices {

/// The arm of a rig file with Denavit-Hartenberg rows: lengths off by 0.5 mm, angles between
/// axes by 1 mrad, zeros by 5 mrad (standard deviations, from the seed); it stands where the
/// file says. Throws std::invalid_argument for an arm in another convention.
[[nodiscard]] ArmWorld arm_of_rig(const geometry::Rig& rig, std::uint64_t seed);

/// The ball in a socket, led there near these joint values.
struct SocketVisit {
  std::string socket;
  Eigen::VectorXd q_rad;
};

/// What the encoders read at each visit. Sockets stand where the nominal arm believes them, up
/// to a few millimetres, as far apart as the rig file says, to within the deviation that it
/// states; each coordinate of a seat scatters by the instrument's sd_mm. Throws
/// std::invalid_argument for a socket that the rig does not have or the arm does not reach.
[[nodiscard]] std::vector<Eigen::VectorXd> seated(
    const ArmWorld& world, const geometry::Rig& rig, std::span<const SocketVisit> visits);

}  // namespace sixdial::mock_devices
