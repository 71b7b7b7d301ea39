// The laws of robots whose controllers take G-code, whatever it is carried in, each over a real
// socket at its mock twin.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <thread>

#include "tests/acquisition/axis_twin.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using mock_devices::GcodeFirmware;
using test::AxisTwin;
using test::TwinOptions;
using testing::HasSubstr;

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kDigit = 0.5e-5 * 1.001;  // of commands, deg or mm

struct Row {
  const char* name;
  std::function<std::unique_ptr<AxisTwin>(const TwinOptions&, const std::string& path)> make;
  double shown = 1e-3;  // it tells where it stands to this, deg or mm
  /// A plain line: it does not tell what others do, and goes on with a move whoever listens.
  bool is_line = false;
  /// Its only stop is the emergency stop, after which it wants a person.
  bool stop_is_final = false;
  /// ... of somebody else's move.
  bool stops_only_its_own = false;
  bool answers_on_the_way = true;
  /// Of a target beyond its travel: it is locked until a person looks, or goes as far as it
  /// can.
  bool locks_itself = false, goes_to_its_end = false;
};

template <GcodeFirmware firmware>
std::unique_ptr<AxisTwin> gcode_twin(const TwinOptions& is, const std::string&) {
  return std::make_unique<test::GcodeTwin>(mock_devices::GcodeMachine{
      .firmware = firmware, .low = is.low, .high = is.high, .work_offset = is.offset});
}

const std::vector<Row> kRows{
    {.name = "klipper",
     .make = [](const TwinOptions& is, const std::string& path) -> std::unique_ptr<AxisTwin> {
       return std::make_unique<test::KlipperTwin>(
           mock_devices::KlipperMachine{
               .low = is.low, .high = is.high, .offset = std::vector<double>(3, is.offset)},
           path);
     },
     .stops_only_its_own = true},
    {.name = "linuxcnc",
     .make = [](const TwinOptions& is, const std::string&) -> std::unique_ptr<AxisTwin> {
       return std::make_unique<test::LinuxCncTwin>(mock_devices::LinuxCncMachine{
           .low = is.low, .high = is.high, .work_offset = is.offset});
     }},
    {.name = "gcode_grbl",
     .make = gcode_twin<GcodeFirmware::kGrbl>,
     .is_line = true,
     .locks_itself = true},
    {.name = "gcode_marlin",
     .make = gcode_twin<GcodeFirmware::kMarlin>,
     .shown = 1e-2,
     .is_line = true,
     .answers_on_the_way = false,
     .goes_to_its_end = true},
    {.name = "gcode_klipper",
     .make = gcode_twin<GcodeFirmware::kKlipper>,
     .is_line = true,
     .stop_is_final = true,
     .answers_on_the_way = false}};

auto rows_that(const std::function<bool(const Row&)>& are) {
  std::vector<Row> rows;
  std::ranges::copy_if(kRows, std::back_inserter(rows), are);
  return testing::ValuesIn(rows);
}
std::string name_of(const testing::TestParamInfo<Row>& each) { return each.param.name; }

class EveryAxisRobot : public testing::TestWithParam<Row> {
 protected:
  void start(const TwinOptions& options = {}) {
    twin_ = GetParam().make(options, folder_.path("socket"));
  }
  std::unique_ptr<RobotPort> robot(const std::string& options = "?feed=60000") {
    return test::opened(twin_->connection(options), clock_);
  }
  double third() { return twin_->position()[2]; }

  test::TemporaryFolder folder_;
  SystemClock clock_;
  std::unique_ptr<AxisTwin> twin_;
};
/// That can be moved on after a halt.
class AxisRobotThatHalts : public EveryAxisRobot {};
/// That are looked at while they move.
class AxisRobotThatAnswers : public EveryAxisRobot {};

TEST_P(EveryAxisRobot, GoesWhereItIsSentAndTellsWhereItIs) {
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
    EXPECT_NEAR(there->q[0], target[0], kDigit * kDeg);
    EXPECT_NEAR(there->q[1], target[1], kDigit * kDeg);
    EXPECT_NEAR(there->q[2], target[2], kDigit);
    EXPECT_NEAR(twin_->position()[0], target[0] / kDeg, kDigit);
    EXPECT_NEAR(twin_->position()[1], target[1] / kDeg, kDigit);
    EXPECT_NEAR(third(), target[2], kDigit);
  }
  EXPECT_EQ(port->state({})->moves, 4);
  EXPECT_EQ(twin_->socket().connections(), 1) << "one connection for all";
}

TEST_P(EveryAxisRobot, TheAxesAreThoseOfTheRigFile) {
  start();
  const auto port = robot("?feed=60000&axes=Z,X,Y");
  const auto there = port->move_to(Eigen::Vector3d(0.5, 0.25, 7.0), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(third(), 0.5 / kDeg, kDigit) << "the first joint is axis Z";
  EXPECT_NEAR(twin_->position()[0], 0.25 / kDeg, kDigit);
  EXPECT_NEAR(twin_->position()[1], 7.0, kDigit);
  EXPECT_NEAR(there->q[0], 0.5, kDigit * kDeg);
  EXPECT_NEAR(there->q[2], 7.0, kDigit);
}

TEST_P(EveryAxisRobot, AnOffsetOfWorkCoordinatesShiftsNothing) {
  start({.offset = 11.5});
  const auto port = robot();
  const auto there = port->move_to(Eigen::Vector3d(0.1, -0.2, 30), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 30.0, kDigit);
  EXPECT_NEAR(third(), 30.0, kDigit);
  EXPECT_NEAR(twin_->position()[0], 0.1 / kDeg, kDigit);
}

TEST_P(EveryAxisRobot, WhatLiesBeyondItsTravelIsRefused) {
  start({.low = -90.0, .high = 90.0});
  const auto port = robot();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 80), 10s, {}));
  for (const double far : {120.0, -91.0}) {
    const auto refused = port->move_to(Eigen::Vector3d(0, 0, far), 10s, {});
    ASSERT_FALSE(refused) << far;
    EXPECT_EQ(
        refused.error().kind,
        GetParam().locks_itself ? RobotFaultKind::kController : RobotFaultKind::kUnreachable)
        << refused.error().detail;
    if (!GetParam().goes_to_its_end) {
      EXPECT_NEAR(third(), 80.0, kDigit) << "it stays where it was";
    }
  }
  const auto next = port->move_to(Eigen::Vector3d(0, 0, 0), 10s, {});
  EXPECT_EQ(next.has_value(), !GetParam().locks_itself) << "the next good one is taken";
  EXPECT_EQ(
      port->move_to(Eigen::Vector3d(0, 0, std::nan("")), 10s, {}).error().kind,
      RobotFaultKind::kUnreachable);
  EXPECT_EQ(
      port->move_to(Eigen::Vector2d(0, 0), 10s, {}).error().kind, RobotFaultKind::kUnreachable);
}

TEST_P(AxisRobotThatHalts, AHaltFromAnotherThreadStopsItOnItsWay) {
  start();
  const auto port = robot("?feed=600");  // ten a second
  ASSERT_TRUE(port->state({}));
  std::jthread other = twin_->once_beyond(2.0, [&] { EXPECT_TRUE(port->halt({})); });
  const auto halted = port->move_to(Eigen::Vector3d(0, 0, 170), 600s, {});
  ASSERT_FALSE(halted);
  EXPECT_EQ(halted.error().kind, RobotFaultKind::kHalted) << halted.error().detail;
  const double stopped = third();
  EXPECT_GT(stopped, 1.0);
  EXPECT_LT(stopped, 120.0);
  EXPECT_TRUE(twin_->stands());
  const auto state = port->state({});
  ASSERT_TRUE(state) << state.error().detail;
  EXPECT_EQ(state->motion, Motion::kFault);
  EXPECT_EQ(state->fault_code, 2);
  EXPECT_NEAR(state->q[2], stopped, GetParam().shown);
  // The next move goes to its own target, and does not end the halted one first.
  // Else it would be far beyond by then: 120 more at ten a second.
  const auto next = port->move_to(Eigen::Vector3d(0, 0, stopped + 0.5), 10s, {});
  ASSERT_TRUE(next) << next.error().detail;
  EXPECT_EQ(next->motion, Motion::kInPosition);
  EXPECT_NEAR(third(), stopped + 0.5, 1e-4);
}

TEST_P(AxisRobotThatHalts, AStoppedMoveAndOneThatDoesNotEndAreHalted) {
  start();
  const auto port = robot("?feed=600");
  std::stop_source stop;
  std::jthread stopper = twin_->once_beyond(1.0, [&] { stop.request_stop(); });
  EXPECT_EQ(
      port->move_to(Eigen::Vector3d(0, 0, 170), 600s, stop.get_token()).error().kind,
      RobotFaultKind::kCancelled);
  stopper.join();
  EXPECT_TRUE(test::eventually([&] { return twin_->stands(); }));
  EXPECT_LT(third(), 120.0);
  const auto rests = port->state({});
  ASSERT_TRUE(rests) << rests.error().detail;
  EXPECT_NEAR(rests->q[2], third(), GetParam().shown) << "no answer from before";
  EXPECT_EQ(
      port->move_to(Eigen::Vector3d(0, 0, -170), 500ms, {}).error().kind,
      RobotFaultKind::kNotThere);
  EXPECT_TRUE(test::eventually([&] { return twin_->stands(); }));
  EXPECT_GT(third(), -120.0);
  const auto next = port->move_to(Eigen::Vector3d(0, 0, third() + 1.0), 60s, {});
  EXPECT_TRUE(next) << next.error().detail;
}

TEST_P(EveryAxisRobot, TheSpeedIsAShareOfTheFeed) {
  start();
  const auto port = robot("?feed=600");
  EXPECT_EQ(port->speed({}).value(), 100);
  ASSERT_TRUE(port->set_speed(50, {}));
  EXPECT_EQ(port->speed({}).value(), 50);
  const auto began = std::chrono::steady_clock::now();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 5), 30s, {}));
  EXPECT_GT(std::chrono::steady_clock::now() - began, 900ms) << "5 mm at 300 mm/min last 1 s";
}

TEST_P(EveryAxisRobot, WhatItDoesNotMoveItselfIsToldAndNotMixedWith) {
  start();
  const auto port = robot();
  ASSERT_TRUE(port->state({}));
  twin_->move_by_hand({0, 0, 170}, 10.0);
  std::this_thread::sleep_for(50ms);
  if (!GetParam().is_line) {
    EXPECT_EQ(port->state({})->motion, Motion::kMoving);
    const auto refused = port->move_to(Eigen::Vector3d(0, 0, 5), 10s, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, RobotFaultKind::kController);
    EXPECT_THAT(refused.error().detail, HasSubstr("end"));
  }
  const auto halted = robot()->halt({});  // as `sixdial robot stop` does
  EXPECT_EQ(halted.has_value(), !GetParam().stops_only_its_own);
  if (GetParam().stops_only_its_own) {
    EXPECT_THAT(halted.error().detail, HasSubstr("emergency stop"));
  } else {
    EXPECT_TRUE(test::eventually([&] { return twin_->stands(); }));
    EXPECT_LT(third(), 160.0);
  }
}

TEST_P(AxisRobotThatHalts, AHaltWhereNothingMovesIsDone) {
  start();
  const auto port = robot();
  const auto halted = port->halt({});
  EXPECT_TRUE(halted) << halted.error().detail;
  EXPECT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
}

TEST_P(EveryAxisRobot, AConnectionThatWasClosedIsTakenUpAgain) {
  start();
  const auto port = robot();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
  twin_->socket().hang_up();
  EXPECT_TRUE(test::eventually([&] { return port->state({}).has_value(); }));
  EXPECT_EQ(port->silent_for(), 0ms);
  EXPECT_TRUE(test::eventually(
      [&] { return port->move_to(Eigen::Vector3d(0, 0, 2), 10s, {}).has_value(); }));
  EXPECT_NEAR(third(), 2.0, kDigit);
}

TEST_P(EveryAxisRobot, AConnectionThatIsClosedOnTheWayIsALinkFault) {
  start();
  const auto port = robot("?feed=600");
  std::jthread other = twin_->once_beyond(1.0, [&] { twin_->socket().hang_up(); });
  const auto lost = port->move_to(Eigen::Vector3d(0, 0, 170), 600s, {});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, RobotFaultKind::kLink) << lost.error().detail;
  if (GetParam().is_line) return;
  EXPECT_TRUE(test::eventually([&] { return twin_->stands(); }));
  EXPECT_LT(third(), 120.0) << "nobody watches it, so it does not go on to its target";
}

TEST_P(AxisRobotThatAnswers, SilenceOnTheWayIsTold) {
  start();
  const auto port = robot("?feed=60");
  std::jthread other = twin_->once_beyond(0.2, [&] { twin_->socket().fall_silent(true); });
  const auto began = std::chrono::steady_clock::now();
  const auto lost = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, {});
  EXPECT_LT(std::chrono::steady_clock::now() - began, test::kInTime);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, RobotFaultKind::kLink) << lost.error().detail;
  EXPECT_THAT(lost.error().detail, HasSubstr("is not answered"));
  std::this_thread::sleep_for(10ms);
  EXPECT_GT(port->silent_for(), 0ms);
  twin_->socket().fall_silent(false);
  EXPECT_TRUE(test::eventually([&] { return port->state({}).has_value(); }));
  EXPECT_EQ(port->silent_for(), 0ms);
}

TEST_P(EveryAxisRobot, HalfAMessageIsNoneAndTheNextIsWhole) {
  start();
  const auto port = robot("?timeout_ms=300");
  ASSERT_TRUE(port->state({}));
  twin_->socket().cut_next(7);
  const auto half = port->state({});
  ASSERT_FALSE(half);
  EXPECT_EQ(half.error().kind, RobotFaultKind::kLink);
  EXPECT_THAT(half.error().detail, HasSubstr("has no end"));
  const auto whole = port->state({});
  EXPECT_TRUE(whole) << whole.error().detail;
}

TEST_P(EveryAxisRobot, WhereNobodyListensThePlaceIsNamed) {
  start();
  const std::string text = twin_->connection("");
  const std::string to = text.substr(0, text.find('?'));
  const auto port = robot("");
  twin_.reset();
  const auto state = port->state({});
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().kind, RobotFaultKind::kLink);
  EXPECT_THAT(state.error().detail, HasSubstr(to.substr(to.find(':') + 1)));
  EXPECT_FALSE(port->halt({}));
}

INSTANTIATE_TEST_SUITE_P(, EveryAxisRobot, testing::ValuesIn(kRows), name_of);
INSTANTIATE_TEST_SUITE_P(
    , AxisRobotThatHalts, rows_that([](const Row& each) { return !each.stop_is_final; }),
    name_of);
INSTANTIATE_TEST_SUITE_P(
    , AxisRobotThatAnswers, rows_that([](const Row& each) { return each.answers_on_the_way; }),
    name_of);

}  // namespace
}  // namespace sixdial::acquisition
