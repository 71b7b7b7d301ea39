// The robot's controller over real Modbus bytes, and the person who stands in for it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/robots/manual_robot.h"
#include "acquisition/robots/modbus_robot.h"
#include "tests/acquisition/controller.h"
#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using test::Controller;
using test::eventually;
using test::ModbusTcpServer;

constexpr double kCount_rad = 0.5e-8;  // half a count of the registers

class Robot : public testing::Test {
 protected:
  ModbusRobot connect(const ModbusTcpServer& server) {
    const auto parsed =
        parse_modbus_robot(fmt::format("modbus-tcp://127.0.0.1:{}", server.port()));
    return {parsed.value(), clock_};
  }
  SystemClock clock_;
  Controller controller_;
};

TEST_F(Robot, TellsWhereItIs) {
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  const auto state = robot.state({});
  ASSERT_TRUE(state) << state.error().detail;
  EXPECT_NEAR(state->q[0], 1.57079633, kCount_rad);
  EXPECT_NEAR(state->q[1], -0.2, kCount_rad);
  EXPECT_DOUBLE_EQ(state->temperature_c.value(), -1.25);
  EXPECT_EQ(state->motion, Motion::kIdle);
}

TEST_F(Robot, ComesBackFromAMoveWhenItIsThere) {
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  for (int i = 1; i <= 5; ++i) {
    const Eigen::Vector2d target(0.1 * i, -1.23456789 - 0.01 * i);
    const auto there = robot.move_to(target, 10s, {});
    ASSERT_TRUE(there) << there.error().detail;
    EXPECT_EQ(there->motion, Motion::kInPosition);
    EXPECT_EQ(there->moves, i);
    EXPECT_NEAR(there->q[0], target[0], kCount_rad);
    EXPECT_NEAR(there->q[1], target[1], kCount_rad);
  }
}

TEST_F(Robot, TheCountOfMovesMayRunOver) {
  controller_.table.input[5] = 65'535;
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  EXPECT_TRUE(robot.move_to(Eigen::Vector2d(0.1, 0.2), 10s, {}));
}

TEST_F(Robot, AnUnreachableTargetIsRefusedAndTheNextMoveIsGood) {
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  const auto refused = robot.move_to(Eigen::Vector2d(5.0, 0.2), 10s, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, RobotFaultKind::kUnreachable);
  EXPECT_TRUE(robot.move_to(Eigen::Vector2d(0.1, 0.2), 10s, {}));
  EXPECT_EQ(
      robot.move_to(Eigen::Vector2d(1e9, 0.2), 10s, {}).error().kind,
      RobotFaultKind::kUnreachable);
  EXPECT_EQ(
      robot.move_to(Eigen::Vector2d(std::nan(""), 0.2), 10s, {}).error().kind,
      RobotFaultKind::kUnreachable);
}

TEST_F(Robot, AMoveThatDoesNotEndIsReportedAndHalted) {
  controller_.polls = 1'000'000;
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  const auto late = robot.move_to(Eigen::Vector2d(0.1, 0.2), 100ms, {});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().kind, RobotFaultKind::kNotThere);
  EXPECT_EQ(robot.state({})->motion, Motion::kFault);
  EXPECT_EQ(robot.state({})->fault_code, 2);
}

TEST_F(Robot, AStoppedMoveHaltsTheRobotInTime) {
  controller_.polls = 1'000'000;
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  std::stop_source stop;
  std::jthread stopper([&] {
    (void)eventually([&] { return server.requests() > 5; });
    stop.request_stop();
  });
  const auto before = steady_clock::now();
  const auto stopped = robot.move_to(Eigen::Vector2d(0.1, 0.2), 600s, stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, RobotFaultKind::kCancelled);
  EXPECT_LT(steady_clock::now() - before, test::kPatience + test::kInTime);
  EXPECT_EQ(robot.state({})->fault_code, 2);
}

TEST_F(Robot, AControllerThatTakesNoCommandIsNoticed) {
  controller_.deaf = true;
  ModbusTcpServer server(controller_.table);
  auto robot = connect(server);
  const auto deaf = robot.move_to(Eigen::Vector2d(0.1, 0.2), 60s, {});
  ASSERT_FALSE(deaf);
  EXPECT_EQ(deaf.error().kind, RobotFaultKind::kController);
}

TEST_F(Robot, ALostAnswerToTheStartDoesNotStartTwice) {
  ModbusTcpServer server(controller_.table);
  server.set_spoil([](int k, std::vector<std::uint8_t>& reply) {
    if (k == 1) reply.clear();  // the start's
  });
  auto robot = connect(server);
  const auto there = robot.move_to(Eigen::Vector2d(0.1, 0.2), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_EQ(there->moves, 1);
}

TEST_F(Robot, AControllerThatIsNotThereIsALinkFault) {
  int port = 0;
  {
    ModbusTcpServer server(controller_.table);
    port = server.port();
  }
  const auto parsed = parse_modbus_robot(fmt::format("modbus-tcp://127.0.0.1:{}", port));
  ModbusRobot robot(parsed.value(), clock_);
  const auto state = robot.state({});
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().kind, RobotFaultKind::kLink);
  EXPECT_THAT(state.error().detail, testing::HasSubstr("disconnected"));
}

// The map behind two joints stays where it was; with three it moves by two registers.
TEST(ModbusRobot, HasTheRegistersOfSoManyJointsAsTheRobot) {
  Controller controller(3);
  ModbusTcpServer server(controller.table);
  SystemClock clock;
  const auto parsed =
      parse_modbus_robot(fmt::format("modbus-tcp://127.0.0.1:{}", server.port()));
  const std::vector<RobotJoint> joints{{"q1", true}, {"q2", true}, {"q3", false}};
  ModbusRobot robot(parsed.value(), clock, joints);
  const Eigen::Vector3d target(0.5, -1.25, 321.4567);
  const auto there = robot.move_to(target, 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_EQ(there->motion, Motion::kInPosition);
  EXPECT_EQ(there->moves, 1);
  EXPECT_NEAR(there->q[0], target[0], kCount_rad);
  EXPECT_NEAR(there->q[1], target[1], kCount_rad);
  EXPECT_NEAR(there->q[2], target[2], 0.5e-5) << "10 nm a count";
  EXPECT_DOUBLE_EQ(there->temperature_c.value(), -1.25);
  ASSERT_TRUE(robot.set_speed(40, {}));
  EXPECT_EQ(controller.table.holding[7], 40);
  ASSERT_TRUE(robot.halt({}));
  EXPECT_EQ(robot.state({})->fault_code, 2);
  EXPECT_EQ(
      robot.move_to(Eigen::Vector3d(0, 0, 30'000), 10s, {}).error().kind,
      RobotFaultKind::kUnreachable)
      << "more than the registers hold";
  EXPECT_EQ(
      robot.move_to(Eigen::Vector2d(0, 0), 10s, {}).error().kind, RobotFaultKind::kUnreachable);
}

TEST(ModbusRobot, AControllerOfAnotherNumberOfJointsIsRefusedBeforeAnythingMoves) {
  SystemClock clock;
  const std::vector<RobotJoint> joints{{"q1", true}, {"q2", true}, {"q3", true}, {"q4", true}};
  for (const int has : {2, 3}) {
    Controller controller(has);
    if (has == 2) controller.table.input.erase(200);  // as they always were
    ModbusTcpServer server(controller.table);
    const auto parsed =
        parse_modbus_robot(fmt::format("modbus-tcp://127.0.0.1:{}", server.port()));
    ModbusRobot robot(parsed.value(), clock, joints);
    const auto refused = robot.move_to(Eigen::Vector4d(0.1, 0.2, 0.3, 0.4), 10s, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, RobotFaultKind::kController);
    EXPECT_THAT(refused.error().detail, testing::HasSubstr(fmt::format("has {} joints", has)));
    EXPECT_FALSE(robot.set_speed(10, {}));
    EXPECT_EQ(controller.table.input[2 * has + 1], 0) << "nothing was started";
  }
}

TEST(ManualRobot, AsksAPersonAndTakesTheirWord) {
  std::vector<Eigen::Vector2d> asked;
  ManualRobot robot([&](const Eigen::Vector2d& q, const std::stop_token&) {
    asked.push_back(q);
    ManualAnswer answer;
    if (asked.size() == 2) answer.q = Eigen::Vector2d(0.5, 0.6);
    if (asked.size() == 3) answer.done = false;
    return asked.size() == 4 ? std::nullopt : std::optional(answer);
  });
  const Eigen::Vector2d target(0.1, 0.2);
  EXPECT_EQ(robot.move_to(target, 1s, {})->q, target);
  EXPECT_EQ(robot.move_to(target, 1s, {})->q, Eigen::Vector2d(0.5, 0.6));
  EXPECT_EQ(robot.move_to(target, 1s, {}).error().kind, RobotFaultKind::kUnreachable);
  EXPECT_EQ(robot.move_to(target, 1s, {}).error().kind, RobotFaultKind::kCancelled);
  EXPECT_EQ(robot.state({})->q, Eigen::Vector2d(0.5, 0.6));
  EXPECT_EQ(asked.size(), 4u);
}

}  // namespace
}  // namespace sixdial::acquisition
