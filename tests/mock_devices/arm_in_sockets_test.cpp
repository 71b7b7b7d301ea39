// The simulated arm puts its ball where the sockets are, by its own lengths, and nowhere else.
#include "mock_devices/arm_in_sockets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSeat_mm = 0.05;

geometry::Rig arm_with_sockets() {
  geometry::Rig rig;
  rig.robot.model = geometry::find_robot_kind("serial")->example();
  rig.robot.nominal = rig.robot.model->nominal;
  rig.instrument.kind = "socket";
  rig.instrument.dimensions = 3;
  rig.instrument.sd_mm = kSeat_mm;
  rig.instrument.sockets = {{.name = "left"}, {.name = "right"}};
  rig.instrument.socket_distances = {{"left", "right", 200.0, 0.01}};
  return rig;
}

/// Visits near one pose of each socket.
std::vector<SocketVisit> visits(const geometry::Rig& rig) {
  std::vector<SocketVisit> result;
  for (int i = 0; i < 40; ++i) {
    VectorXd q = VectorXd::Constant(rig.robot.model->joint_count(), 0.4);
    q[0] = i % 2 == 0 ? 0.3 : 0.6;
    result.push_back({i % 2 == 0 ? "left" : "right", q});
  }
  return result;
}

TEST(ArmInSockets, SitsInTheSameTwoPlacesToWithinTheSeat) {
  const geometry::Rig rig = arm_with_sockets();
  const ArmWorld world = arm_of_rig(rig, 5);
  const auto planned = visits(rig);
  const auto read = seated(world, rig, planned);
  ASSERT_EQ(read.size(), planned.size());
  std::map<std::string, Vector3d> mean;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Vector3d at = tool_of_arm(world, read[i]);
    const auto [found, fresh] = mean.emplace(planned[i].socket, Vector3d::Zero());
    found->second += at / 20.0;
  }
  double squares = 0.0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    squares += (tool_of_arm(world, read[i]) - mean.at(planned[i].socket)).squaredNorm();
  }
  // 120 coordinates know a standard deviation to 7 %.
  EXPECT_NEAR(std::sqrt(squares / (3.0 * 38.0)), kSeat_mm, 0.25 * kSeat_mm);
  const double apart = (mean.at("left") - mean.at("right")).norm();
  EXPECT_LT(std::abs(apart - 200.0), 0.1);
  // The arm is not the one of the file: led there, its encoders read something else.
  EXPECT_GT((read[0] - planned[0].q_rad).norm(), 1e-3);
}

TEST(ArmInSockets, AnUnknownSocketOrAnotherRobotIsRefused) {
  const geometry::Rig rig = arm_with_sockets();
  const ArmWorld world = arm_of_rig(rig, 5);
  const std::vector<SocketVisit> nowhere{{"middle", visits(rig)[0].q_rad}};
  EXPECT_THROW(static_cast<void>(seated(world, rig, nowhere)), std::invalid_argument);
  EXPECT_THROW(
      static_cast<void>(arm_of_rig(geometry::default_rig(), 1)), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::mock_devices
