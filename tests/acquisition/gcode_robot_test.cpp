// Robots that take G-code, over a real socket and a real pseudo-terminal, at their mock twins.
#include "acquisition/robots/gcode_robot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "acquisition/robot_driver.h"
#include "mock_devices/gcode_line.h"
#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using mock_devices::GcodeFirmware;
using mock_devices::GcodeLineServer;
using mock_devices::GcodeMachine;
using testing::HasSubstr;

constexpr double kDeg = std::numbers::pi / 180.0;
const std::vector<RobotJoint> kJoints{{"q1", true}, {"q2", true}, {"q3", false}};

struct Firmware {
  GcodeFirmware is;
  const char* dialect;
  double digit;  // of its reports, deg or mm
};
constexpr std::array kFirmwares{
    Firmware{GcodeFirmware::kGrbl, "grbl", 1e-3},
    Firmware{GcodeFirmware::kMarlin, "marlin", 1e-2},
    Firmware{GcodeFirmware::kKlipper, "klipper", 1e-3}};

class EveryGcode : public testing::TestWithParam<Firmware> {
 protected:
  void start(GcodeMachine machine = {}, double speed = 1.0) {
    machine.firmware = GetParam().is;
    server_ = std::make_unique<GcodeLineServer>(
        machine,
        mock_devices::GcodeLineOptions{.pty_link = folder_.path("machine"), .speed = speed});
  }
  std::unique_ptr<RobotPort> robot(std::string_view more = "&feed=60000") {
    return opened(fmt::format(
        "gcode-tcp:127.0.0.1:{}?dialect={}{}", server_->port(), GetParam().dialect, more));
  }
  std::unique_ptr<RobotPort> opened(const std::string& text) {
    const auto connection = parse_robot_connection(text, kJoints);
    EXPECT_TRUE(connection) << connection.error();
    return connection->open({.clock = clock_});
  }
  test::TemporaryFolder folder_;
  SystemClock clock_;
  std::unique_ptr<GcodeLineServer> server_;
};

TEST_P(EveryGcode, GoesWhereItIsSentAndTellsWhereItIs) {
  start();
  const auto port = robot();
  const auto before = port->state({});
  ASSERT_TRUE(before) << before.error().detail;
  EXPECT_EQ(before->motion, Motion::kIdle);
  for (int i = 1; i <= 4; ++i) {
    const Eigen::Vector3d target(0.3 * i, -0.123456 * i, 12.3456 * i);
    const auto there = port->move_to(target, 10s, {});
    ASSERT_TRUE(there) << there.error().detail;
    EXPECT_EQ(there->motion, Motion::kInPosition);
    EXPECT_EQ(there->moves, i);
    // To the digits of the command: those of the report are fewer, and agree.
    EXPECT_NEAR(there->q[0], target[0], 0.5e-5 * kDeg * 1.001);
    EXPECT_NEAR(there->q[1], target[1], 0.5e-5 * kDeg * 1.001);
    EXPECT_NEAR(there->q[2], target[2], 0.5e-5 * 1.001);
    EXPECT_NEAR(server_->position()[0], target[0] / kDeg, 1e-5);
    EXPECT_NEAR(server_->position()[2], target[2], 1e-5);
  }
  EXPECT_EQ(server_->moves(), 4);
}

TEST_P(EveryGcode, OverASerialLineToo) {
  start();
  const auto port = opened(fmt::format(
      "gcode-serial:{}?dialect={}&baud=115200&axes=Z,X,Y&feed=60000", folder_.path("machine"),
      GetParam().dialect));
  const auto there = port->move_to(Eigen::Vector3d(0.5, 0.25, 7.0), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(server_->position()[2], 0.5 / kDeg, 1e-5) << "the first joint is axis Z";
  EXPECT_NEAR(server_->position()[0], 0.25 / kDeg, 1e-5);
  EXPECT_NEAR(server_->position()[1], 7.0, 1e-5);
}

// A stepper stands at a multiple of its step: what it says then is the truth, not the command.
TEST_P(EveryGcode, AJointThatStandsElsewhereByMoreThanADigitIsWhereItSays) {
  start({.step = 0.04});
  const auto port = robot();
  const auto there = port->move_to(Eigen::Vector3d(0, 0, 10.015), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 10.0, GetParam().digit);
}

TEST_P(EveryGcode, WhatLiesBeyondItsTravelIsRefused) {
  start({.low = -90.0, .high = 90.0});
  const auto port = robot();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 80), 10s, {}));
  const auto refused = port->move_to(Eigen::Vector3d(0, 0, 120), 10s, {});
  ASSERT_FALSE(refused);
  if (GetParam().is == GcodeFirmware::kGrbl) {  // and locked, until a person looks
    EXPECT_EQ(refused.error().kind, RobotFaultKind::kController);
    EXPECT_THAT(refused.error().detail, HasSubstr("travel"));
    const auto locked = port->move_to(Eigen::Vector3d(0, 0, 0), 10s, {});
    ASSERT_FALSE(locked);
    EXPECT_THAT(locked.error().detail, HasSubstr("$X"));
    return;
  }
  EXPECT_EQ(refused.error().kind, RobotFaultKind::kUnreachable) << refused.error().detail;
  EXPECT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 0), 10s, {})) << "the next good one is taken";
  EXPECT_EQ(
      port->move_to(Eigen::Vector3d(0, 0, std::nan("")), 10s, {}).error().kind,
      RobotFaultKind::kUnreachable);
  EXPECT_EQ(
      port->move_to(Eigen::Vector2d(0, 0), 10s, {}).error().kind, RobotFaultKind::kUnreachable);
}

TEST_P(EveryGcode, AHaltFromAnotherThreadStopsItOnItsWay) {
  start();
  const auto port = robot("&feed=60");  // a degree a second
  ASSERT_TRUE(port->state({}));
  std::jthread other([&] {
    EXPECT_TRUE(test::eventually([&] { return server_->position()[2] > 0.2; }));
    EXPECT_TRUE(port->halt({}));
  });
  const auto halted = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, {});
  ASSERT_FALSE(halted);
  const double stands = server_->position()[2];
  EXPECT_GT(stands, 0.1);
  EXPECT_LT(stands, 50.0);
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(server_->position()[2], stands) << "it stands";
  if (GetParam().is == GcodeFirmware::kKlipper) {  // its only stop is the emergency stop
    EXPECT_EQ(halted.error().kind, RobotFaultKind::kController);
    EXPECT_FALSE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
    return;
  }
  EXPECT_EQ(halted.error().kind, RobotFaultKind::kHalted) << halted.error().detail;
  EXPECT_EQ(port->state({})->motion, Motion::kFault);
  EXPECT_NEAR(port->state({})->q[2], stands, GetParam().digit);
  // The next move goes to its own target, and does not end the halted one first.
  const int moves = server_->moves();
  ASSERT_TRUE(port->set_speed(100, {}));
  const auto next = port->move_to(Eigen::Vector3d(0, 0, stands + 0.5), 60s, {});
  ASSERT_TRUE(next) << next.error().detail;
  EXPECT_EQ(server_->moves(), moves + 1);
  EXPECT_NEAR(server_->position()[2], stands + 0.5, 1e-4);
}

TEST_P(EveryGcode, AStoppedMoveAndOneThatDoesNotEndAreHalted) {
  start();
  const auto port = robot("&feed=60");
  std::stop_source stop;
  std::jthread stopper([&] {
    EXPECT_TRUE(test::eventually([&] { return server_->position()[2] > 0.1; }));
    stop.request_stop();
  });
  EXPECT_EQ(
      port->move_to(Eigen::Vector3d(0, 0, 100), 600s, stop.get_token()).error().kind,
      RobotFaultKind::kCancelled);
  stopper.join();
  std::this_thread::sleep_for(100ms);
  const double stands = server_->position()[2];
  EXPECT_LT(stands, 50.0);
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(server_->position()[2], stands);
  if (GetParam().is == GcodeFirmware::kKlipper) return;
  EXPECT_EQ(
      port->move_to(Eigen::Vector3d(0, 0, 100), 500ms, {}).error().kind,
      RobotFaultKind::kNotThere);
  std::this_thread::sleep_for(100ms);
  const double later = server_->position()[2];
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(server_->position()[2], later);
}

TEST_P(EveryGcode, TheSpeedIsAShareOfTheFeed) {
  start();
  const auto port = robot("&feed=600");
  EXPECT_EQ(port->speed({}).value(), 100);
  ASSERT_TRUE(port->set_speed(50, {}));
  EXPECT_EQ(port->speed({}).value(), 50);
  const auto began = std::chrono::steady_clock::now();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 5), 30s, {}));
  EXPECT_GT(std::chrono::steady_clock::now() - began, 900ms) << "5 mm at 300 mm/min last 1 s";
}

TEST_P(EveryGcode, AnotherDialectOrAStrangerIsTold) {
  start();
  const char* const other = GetParam().is == GcodeFirmware::kGrbl ? "klipper" : "grbl";
  const auto port = opened(fmt::format(
      "gcode-tcp:127.0.0.1:{}?dialect={}&timeout_ms=300&boot_ms=500", server_->port(), other));
  const auto state = port->state({});
  ASSERT_FALSE(state);
  EXPECT_FALSE(state.error().detail.empty());
}

TEST_P(EveryGcode, AConnectionThatWasClosedIsTakenUpAgain) {
  start();
  const auto port = robot();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
  server_->hang_up();
  EXPECT_TRUE(test::eventually([&] { return port->state({}).has_value(); }));
  EXPECT_EQ(port->silent_for(), 0ms);
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 2), 10s, {}));
  EXPECT_NEAR(server_->position()[2], 2.0, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(, EveryGcode, testing::ValuesIn(kFirmwares), [](const auto& each) {
  return std::string(each.param.dialect);
});

class GrblRobot : public testing::Test {
 protected:
  std::unique_ptr<RobotPort> opened(GcodeLineServer& server) {
    const auto connection = parse_robot_connection(
        fmt::format("gcode-tcp:127.0.0.1:{}?dialect=grbl&feed=60000", server.port()), kJoints);
    return connection.value().open({.clock = clock_});
  }
  SystemClock clock_;
};

TEST_F(GrblRobot, TheWorkOffsetIsTakenFromWhatTheMachineReports) {
  GcodeLineServer server({.work_offset = -123.456}, {});
  const auto port = opened(server);
  const auto there = port->move_to(Eigen::Vector3d(0.1, 0.2, 30), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 30.0, 1e-5);
}

TEST_F(GrblRobot, AControllerThatBeganAnewIsNotedAndNothingGoesOnUnseen) {
  GcodeLineServer server({}, {});
  const auto port = opened(server);
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 30), 10s, {}));
  server.with([](auto& machine, double time_s) { machine.restart(time_s); });
  std::this_thread::sleep_for(50ms);
  const auto state = port->state({});
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(state.error().detail, HasSubstr("home it"));
}

TEST_F(GrblRobot, AFeedHoldAtTheMachineIsAHalt) {
  GcodeLineServer server({}, {});
  const auto connection = parse_robot_connection(
      fmt::format("gcode-tcp:127.0.0.1:{}?dialect=grbl&feed=60", server.port()), kJoints);
  const auto port = connection.value().open({.clock = clock_});
  std::jthread person([&] {
    EXPECT_TRUE(test::eventually([&] { return server.position()[2] > 0.1; }));
    server.with([](auto& machine, double time_s) { machine.receive("!", time_s); });
  });
  const auto held = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, {});
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().kind, RobotFaultKind::kHalted) << held.error().detail;
}

TEST(GcodeConnection, ARefusalSaysWhatWouldBeRight) {
  const auto refusal = [](std::string_view text) {
    const auto parsed = parse_robot_connection(text, kJoints);
    return parsed ? "" : parsed.error();
  };
  EXPECT_EQ(refusal("gcode-tcp:10.0.0.7:23?dialect=grbl"), "");
  EXPECT_EQ(refusal("gcode-tcp://[::1]:23?dialect=grbl&axes=ABC"), "");
  EXPECT_THAT(refusal("gcode-tcp:10.0.0.7:23"), HasSubstr("dialect= one of grbl"));
  EXPECT_THAT(refusal("gcode-tcp:10.0.0.7?dialect=grbl"), HasSubstr("no port"));
  EXPECT_THAT(refusal("gcode-tcp:h:23?dialect=gerbil"), HasSubstr("did you mean 'grbl'"));
  EXPECT_THAT(refusal("gcode-tcp:h:23?dialect=grbl&axes=X,Y"), HasSubstr("3 joints"));
  EXPECT_THAT(refusal("gcode-tcp:h:23?dialect=grbl&axes=X,Y,Y"), HasSubstr("twice"));
  EXPECT_THAT(refusal("gcode-tcp:h:23?dialect=grbl&axes=X,Y,Q"), HasSubstr("none of the axes"));
  EXPECT_THAT(refusal("gcode-tcp:h:23?dialect=grbl&feed=-1"), HasSubstr("above 0"));
  EXPECT_THAT(refusal("gcode-tcp:h:23?dialect=grbl&baud=9600"), HasSubstr("unknown key"));
  EXPECT_THAT(refusal("gcode-serial:ttyUSB0?dialect=grbl"), HasSubstr("not a device path"));
}

}  // namespace
}  // namespace sixdial::acquisition
