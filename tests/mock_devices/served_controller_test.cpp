// A mock rig whose robot is moved by machines that take G-code: what is typed on their cables
// moves its joints.
#include "mock_devices/served_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "mock_devices/mock_arm.h"
#include "tests/mock_devices/raw_port.h"

namespace sixdial::mock_devices {
namespace {

constexpr double kDegPerRad = 180.0 / 3.14159265358979323846;

using ServedControllerTest = MockRigTest;

std::string move_to(const Vector2d& q_rad, double feed) {
  std::array<char, 80> text{};
  const int n = std::snprintf(
      text.data(), text.size(), "G1 X%.5f Y%.5f F%.0f\n", kDegPerRad * q_rad[0],
      kDegPerRad * q_rad[1], feed);
  return {text.data(), static_cast<std::size_t>(n)};
}

bool ends_with_ok(const std::string& got) { return got.find("ok\r\n") != std::string::npos; }

TEST_F(ServedControllerTest, TheRigBeginsWhereTheMachineDoesAndGoesWithIt) {
  MockRigOptions with = options(20.0);
  with.robot_controller = "grbl";
  MockRig rig(with);
  rig.start();
  const Vector2d home = rig.robot().q_rad;
  const Vector2d target = angles(rig, {25, 50});
  ASSERT_GT((target - home).norm(), 0.02);
  Port grbl(Port::tcp(rig.ports().robot));
  grbl.send("?");
  const std::string status =
      grbl.read_until([](const std::string& got) { return got.ends_with(">\r\n"); });
  std::array<char, 32> place{};
  std::snprintf(place.data(), place.size(), "MPos:%.3f,", kDegPerRad * home[0]);
  EXPECT_NE(status.find(place.data()), std::string::npos) << status;

  grbl.send(move_to(target, 3000) + "G4 P0.01\n");
  grbl.read_until([](const std::string& got) {
    return got.find("ok\r\n") != got.rfind("ok\r\n");  // of both lines
  });
  const auto limit = Clock::now() + std::chrono::milliseconds(kPatience_ms);
  while ((rig.robot().q_rad - target).norm() > 1e-6 && Clock::now() < limit) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_LT((rig.robot().q_rad - target).norm(), 1e-6);
  EXPECT_EQ(rig.robot().moves_started, 1);
}

TEST_F(ServedControllerTest, AStopIsAStopAndPiecesOfAMoveAreOneMove) {
  MockRigOptions with = options(1.0);
  with.robot_controller = "grbl";
  MockRig rig(with);
  rig.start();
  const Vector2d home = rig.robot().q_rad;
  const Vector2d target = angles(rig, {25, 50});
  Port grbl(Port::tcp(rig.ports().robot));
  // Two pieces on one straight line, slowly.
  grbl.send(move_to(home + 0.5 * (target - home), 60) + move_to(target, 60));
  grbl.read_until(ends_with_ok);
  const auto begun_by = Clock::now() + std::chrono::milliseconds(kPatience_ms);
  while (rig.robot().state != MotionState::kMoving && Clock::now() < begun_by) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  while ((rig.robot().q_rad - home).norm() < 1e-3 && Clock::now() < begun_by) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  grbl.send("!");
  const auto stands = [&] {
    const Vector2d before = rig.robot().q_rad;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return (rig.robot().q_rad - before).norm() < 1e-9;
  };
  const auto limit = Clock::now() + std::chrono::milliseconds(kPatience_ms);
  while (!stands() && Clock::now() < limit) {
  }
  const Vector2d there = rig.robot().q_rad;
  EXPECT_GT((there - home).norm(), 1e-4);
  EXPECT_GT((there - target).norm(), 1e-3);
  EXPECT_EQ(rig.robot().moves_started, 1);
}

TEST_F(ServedControllerTest, EachSaysHowToConnect) {
  for (const std::string_view name : served_controllers()) {
    MockRigOptions with = options();
    with.robot_controller = std::string(name);
    with.robot_link = folder_ / "robot";
    MockRig rig(with);
    rig.start();
    const std::string connection = rig.robot_connection();
    EXPECT_EQ(rig.connected_rig("modbus-tcp").robot.connection, connection);
    if (name == "klipper-socket") {
      EXPECT_EQ(connection, "klipper:" + (folder_ / "robot").string());
      EXPECT_TRUE(std::filesystem::is_socket(folder_ / "robot"));
      EXPECT_EQ(rig.ports().robot, 0);
    } else {
      EXPECT_NE(connection.find(std::to_string(rig.ports().robot)), std::string::npos);
      EXPECT_EQ(rig.robot_serial_connection().empty(), name == "linuxcnc") << name;
    }
  }
  MockRigOptions with = options();
  with.robot_controller = "mach3";
  MockRig rig(with);
  EXPECT_THROW(rig.start(), std::invalid_argument);
}

TEST_F(ServedControllerTest, AMachineWithTooFewAxesIsRefused) {
  MockArmOptions options{.world = drawn_arm(3, 5)};
  options.robot_controller = "klipper-socket";
  MockArm arm(options);
  EXPECT_THROW(arm.start(), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::mock_devices
