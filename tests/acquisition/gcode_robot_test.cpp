// What robots alone have that take G-code line by line: firmwares, a serial line, and what a
// controller says unasked. Their laws: every_axis_robot_test.cpp.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <thread>

#include "tests/acquisition/axis_twin.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using mock_devices::GcodeFirmware;
using mock_devices::GcodeMachine;
using test::GcodeTwin;
using test::refusal;
using testing::HasSubstr;

constexpr double kDeg = std::numbers::pi / 180.0;

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
  void start(GcodeMachine machine = {}) {
    machine.firmware = GetParam().is;
    twin_ = std::make_unique<GcodeTwin>(machine, folder_.path("machine"));
  }
  test::TemporaryFolder folder_;
  SystemClock clock_;
  std::unique_ptr<GcodeTwin> twin_;
};

TEST_P(EveryGcode, OverASerialLineToo) {
  start();
  const auto port = test::opened(
      fmt::format(
          "gcode-serial:{}?dialect={}&baud=115200&axes=Z,X,Y&feed=60000",
          folder_.path("machine"), GetParam().dialect),
      clock_);
  const auto there = port->move_to(Eigen::Vector3d(0.5, 0.25, 7.0), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(twin_->position()[2], 0.5 / kDeg, 1e-5) << "the first joint is axis Z";
  EXPECT_NEAR(twin_->position()[0], 0.25 / kDeg, 1e-5);
  EXPECT_NEAR(twin_->position()[1], 7.0, 1e-5);
}

// A stepper stands at a multiple of its step: what it says then is the truth, not the command.
TEST_P(EveryGcode, AJointThatStandsElsewhereByMoreThanADigitIsWhereItSays) {
  start({.step = 0.04});
  const auto port = test::opened(twin_->connection("?feed=60000"), clock_);
  const auto there = port->move_to(Eigen::Vector3d(0, 0, 10.015), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 10.0, GetParam().digit);
}

TEST_P(EveryGcode, AnotherDialectOrAStrangerIsTold) {
  start();
  const char* const other = GetParam().is == GcodeFirmware::kGrbl ? "klipper" : "grbl";
  const auto port = test::opened(
      fmt::format(
          "gcode-tcp:127.0.0.1:{}?dialect={}&timeout_ms=300&boot_ms=500",
          twin_->socket().port(), other),
      clock_);
  const auto state = port->state({});
  ASSERT_FALSE(state);
  EXPECT_FALSE(state.error().detail.empty());
}

INSTANTIATE_TEST_SUITE_P(, EveryGcode, testing::ValuesIn(kFirmwares), [](const auto& each) {
  return std::string(each.param.dialect);
});

class GcodeRobotTest : public testing::Test {
 protected:
  std::unique_ptr<RobotPort> robot(
      const GcodeTwin& twin, const std::string& options = "?feed=60000") {
    return test::opened(twin.connection(options), clock_);
  }
  SystemClock clock_;
};

TEST_F(GcodeRobotTest, TheOnlyStopOfKlippersPseudoTerminalIsItsEmergencyStop) {
  for (const bool cancelled : {false, true}) {
    GcodeTwin twin({.firmware = GcodeFirmware::kKlipper});
    const auto port = robot(twin, "?feed=60");  // a degree a second
    ASSERT_TRUE(port->state({}));
    std::stop_source stop;
    std::jthread other = twin.once_beyond(0.2, [&] {
      if (cancelled) {
        stop.request_stop();
      } else {
        EXPECT_TRUE(port->halt({}));
      }
    });
    const auto halted = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, stop.get_token());
    ASSERT_FALSE(halted);
    EXPECT_EQ(
        halted.error().kind,
        cancelled ? RobotFaultKind::kCancelled : RobotFaultKind::kController);
    EXPECT_TRUE(test::eventually([&] { return twin.stands(); }));
    EXPECT_GT(twin.position()[2], 0.1);
    EXPECT_LT(twin.position()[2], 50.0);
    EXPECT_FALSE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
  }
}

TEST_F(GcodeRobotTest, ATargetBeyondItsTravelLocksGrblUntilAPersonLooks) {
  GcodeTwin twin({.low = -90.0, .high = 90.0});
  const auto port = robot(twin);
  const auto refused = port->move_to(Eigen::Vector3d(0, 0, 120), 10s, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail, HasSubstr("travel"));
  const auto locked = port->move_to(Eigen::Vector3d(0, 0, 0), 10s, {});
  ASSERT_FALSE(locked);
  EXPECT_THAT(locked.error().detail, HasSubstr("$X"));
}

TEST_F(GcodeRobotTest, AControllerThatBeganAnewIsNotedAndNothingGoesOnUnseen) {
  GcodeTwin twin({});
  const auto port = robot(twin);
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 30), 10s, {}));
  twin.socket().with([&](double time_s) { twin.cable.machine().restart(time_s); });
  std::this_thread::sleep_for(50ms);
  const auto state = port->state({});
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(state.error().detail, HasSubstr("home it"));
}

TEST_F(GcodeRobotTest, AFeedHoldAtTheMachineIsAHalt) {
  GcodeTwin twin({});
  const auto port = robot(twin, "?feed=60");
  std::jthread person = twin.once_beyond(0.1, [&] {
    twin.socket().with([&](double time_s) { twin.cable.machine().receive("!", time_s); });
  });
  const auto held = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, {});
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().kind, RobotFaultKind::kHalted) << held.error().detail;
}

// The machine says nothing before the halt has been asked for, so that the move cannot begin
// before, and hears nothing of it: what keeps it from moving is this side alone.
TEST_F(GcodeRobotTest, AHaltThatComesWhileItGetsReadyIsNotLost) {
  for (const auto firmware : {GcodeFirmware::kGrbl, GcodeFirmware::kMarlin}) {
    GcodeTwin twin({.firmware = firmware});
    twin.socket().fall_silent(true);
    const auto port = robot(twin, "?feed=6000&timeout_ms=20000&boot_ms=20000");
    std::jthread other([&] {
      EXPECT_TRUE(test::eventually([&] { return twin.socket().connections() == 1; }));
      EXPECT_TRUE(port->halt({}));
      twin.socket().fall_silent(false);
    });
    const auto halted = port->move_to(Eigen::Vector3d(0, 0, 20), 30s, {});
    ASSERT_FALSE(halted);
    EXPECT_THAT(
        halted.error().kind, testing::AnyOf(RobotFaultKind::kHalted, RobotFaultKind::kLink))
        << halted.error().detail;
    EXPECT_EQ(twin.position()[2], 0.0);
    other.join();
    const auto next = port->move_to(Eigen::Vector3d(0, 0, 1), 30s, {});
    EXPECT_TRUE(next) << "the next one is taken: " << next.error().detail;
  }
}

TEST(GcodeConnection, ARefusalSaysWhatWouldBeRight) {
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
