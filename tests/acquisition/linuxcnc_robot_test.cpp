// LinuxCNC's remote: lines typed from its manual page and from what its source prints, and a
// machine with an operator.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <thread>

#include "acquisition/robot_driver.h"
#include "acquisition/robots/linuxcnc/lines.h"
#include "tests/acquisition/axis_twin.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using mock_devices::LinuxCncMachine;
using test::refusal;
using testing::ElementsAre;
using testing::HasSubstr;

CncLine read(std::string_view text) {
  const auto line = parse_linuxcnc(text);
  EXPECT_TRUE(line) << text;
  return line.value_or(CncLine{});
}

TEST(LinuxCncLines, AnswersOfItsPagesAreRead) {
  EXPECT_EQ(read("HELLO ACK EMCNETSVR 1.1").kind, CncLineKind::kAck);
  EXPECT_EQ(read("HELLO ACK EMCNETSVR 1.1").name, "HELLO");
  EXPECT_EQ(read("HELLO NAK").kind, CncLineKind::kNak);
  EXPECT_EQ(read("SET MDI ACK").kind, CncLineKind::kAck);
  EXPECT_EQ(read("SET MDI ACK").name, "MDI");
  EXPECT_EQ(read("\rSET MODE NAK").kind, CncLineKind::kNak) << "after a line that ended \\n\\r";
  EXPECT_EQ(read("SET NAK").kind, CncLineKind::kNak);
  EXPECT_EQ(read("GET JOINT_POS NAK").name, "JOINT_POS");
  const CncLine position = read("ABS_ACT_POS 1.000000 -2.500000 0.000000 0 0 0");
  EXPECT_EQ(position.kind, CncLineKind::kValue);
  EXPECT_EQ(position.name, "ABS_ACT_POS");
  EXPECT_THAT(cnc_figures(position.rest).value(), ElementsAre(1.0, -2.5, 0.0, 0.0, 0.0, 0.0));
  EXPECT_EQ(read("ERROR OK").rest, "OK");
  EXPECT_EQ(
      read("ERROR Linear move on line 0 would exceed joint 0's positive limit").rest,
      "Linear move on line 0 would exceed joint 0's positive limit");
  const CncLine error = read("error: emc_error: bad status from LinuxCNC");
  EXPECT_EQ(error.kind, CncLineKind::kError);
  EXPECT_EQ(error.rest, "emc_error: bad status from LinuxCNC");
  EXPECT_THAT(cnc_words("YES YES NO"), ElementsAre("YES", "YES", "NO"));
}

TEST(LinuxCncLines, EchoesAndWarningsAreNoAnswers) {
  for (const char* const text :
       {"set mode mdi", "get abs_act_pos", "hello EMC user 1.0", "",
        "WARNING: \"set_wait\" command is deprecated", "SET MDI", "SET MDI DONE",
        "GET X ACK"}) {
    EXPECT_EQ(read(text).kind, CncLineKind::kRemark) << text;
  }
  EXPECT_FALSE(parse_linuxcnc("\x80\x01"));
  EXPECT_FALSE(parse_linuxcnc(std::string_view("SET MDI ACK\0", 12)));
}

TEST(LinuxCncLines, FiguresAreWhole) {
  for (const char* const text : {"1.0 x", "nan", "inf", "1e3", "1.0,2.0", "1e300", "0x10"}) {
    EXPECT_FALSE(cnc_figures(text)) << text;
  }
  EXPECT_EQ(cnc_unit("INCH"), 25.4);
  EXPECT_NEAR(cnc_unit("RAD").value() * std::numbers::pi, 180.0, 1e-9);
  EXPECT_EQ(cnc_unit("CUSTOM"), std::nullopt);
}

class LinuxCncTest : public testing::Test {
 protected:
  void start(LinuxCncMachine machine = {}) {
    twin_ = std::make_unique<test::LinuxCncTwin>(std::move(machine));
  }
  std::unique_ptr<RobotPort> robot(const std::string& options = "?feed=60000") {
    return test::opened(twin_->connection(options), clock_);
  }
  std::string trouble(LinuxCncMachine machine, const std::string& options = "") {
    start(std::move(machine));
    const auto state = robot(options)->state({});
    EXPECT_FALSE(state);
    if (state) return "";
    EXPECT_EQ(state.error().kind, RobotFaultKind::kController) << state.error().detail;
    return state.error().detail;
  }
  SystemClock clock_;
  std::unique_ptr<test::LinuxCncTwin> twin_;
};

TEST_F(LinuxCncTest, VersionsBefore2_10AreSpokenToAsWell) {
  start({.old = true, .waits_done = true});
  const auto port = robot("?feed=6000");
  const auto there = port->move_to(Eigen::Vector3d(0, 0, 30), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 30.0, 1e-5);
}

TEST_F(LinuxCncTest, AWaitThatAnotherClientSetDoesNotHideTheMove) {
  start({.waits_done = true});
  const auto port = robot("?feed=600&timeout_ms=500");
  const auto there = port->move_to(Eigen::Vector3d(0, 0, 15), 30s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 15.0, 1e-5);
}

TEST_F(LinuxCncTest, AMachineInInchesStandsWhereItWasSentInMillimetres) {
  start({.units = "INCH"});
  const auto there = robot()->move_to(Eigen::Vector3d(0, 0, 25.4), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 25.4, 2e-5) << "six digits of an inch";
  EXPECT_NEAR(twin_->position()[2], 25.4, 1e-5);
}

TEST_F(LinuxCncTest, AJointThatStandsElsewhereIsWhereItSays) {
  start({.step = 0.04});
  const auto there = robot()->move_to(Eigen::Vector3d(0, 0, 10.015), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_NEAR(there->q[2], 10.0, 1e-6);
  start({.step = 0.5});
  const auto off = robot()->move_to(Eigen::Vector3d(0, 0, 10.2), 10s, {});
  ASSERT_FALSE(off);
  EXPECT_THAT(off.error().detail, HasSubstr("Z (q3) stands at 10 and was sent to 10.2"));
}

TEST_F(LinuxCncTest, WhyItCannotMoveIsTold) {
  EXPECT_THAT(trouble({.password = "secret"}), HasSubstr("password="));
  EXPECT_THAT(trouble({.enable = "secret"}), HasSubstr("enable="));
  EXPECT_THAT(trouble({.estop = true, .on = false}), HasSubstr("emergency stop is on"));
  EXPECT_THAT(trouble({.on = false}), HasSubstr("switched off"));
  EXPECT_THAT(trouble({.homed = false}), HasSubstr("joint 0 is not homed"));
  EXPECT_THAT(trouble({.kinematics = 4}), HasSubstr("trivkins"));
  EXPECT_THAT(trouble({.units = "CUSTOM"}), HasSubstr("LINEAR_UNITS"));
  start({.password = "one", .enable = "two"});
  EXPECT_TRUE(robot("?password=one&enable=two")->state({}));
}

TEST_F(LinuxCncTest, TheEmergencyStopOnTheWayEndsTheMoveAtOnce) {
  start();
  const auto port = robot("?feed=60");
  std::jthread person = twin_->once_beyond(0.2, [&] {
    twin_->socket().with([&](double time_s) { twin_->remote.press_estop(time_s); });
  });
  const auto began = std::chrono::steady_clock::now();
  const auto ended = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, {});
  EXPECT_LT(std::chrono::steady_clock::now() - began, test::kInTime);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(ended.error().detail, HasSubstr("emergency stop"));
}

TEST_F(LinuxCncTest, AMoveThatIsPausedAtTheMachineIsHaltedAndNeverResumed) {
  start();
  const auto port = robot("?feed=600");
  std::jthread person = twin_->once_beyond(
      1.0, [&] { twin_->socket().with([&](double time_s) { twin_->remote.pause(time_s); }); });
  const auto paused = port->move_to(Eigen::Vector3d(0, 0, 170), 600s, {});
  ASSERT_FALSE(paused);
  EXPECT_EQ(paused.error().kind, RobotFaultKind::kHalted) << paused.error().detail;
  EXPECT_EQ(port->state({})->motion, Motion::kFault);
  const auto next = port->move_to(Eigen::Vector3d(0, 0, 0.5), 60s, {});
  ASSERT_TRUE(next) << next.error().detail;
  EXPECT_NEAR(twin_->position()[2], 0.5, 1e-5);
}

TEST_F(LinuxCncTest, ControlThatAnotherClientTookIsToldAndTakenBackByTheNextMove) {
  start();
  const auto port = robot();
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
  twin_->socket().with([&](double) { twin_->remote.take_control(); });
  const auto refused = port->move_to(Eigen::Vector3d(0, 0, 2), 10s, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail, HasSubstr("set mode mdi is refused"));
  EXPECT_THAT(refused.error().detail, HasSubstr("another client"));
  EXPECT_NEAR(twin_->position()[2], 1.0, 1e-5);
  const auto next = port->move_to(Eigen::Vector3d(0, 0, 2), 10s, {});
  EXPECT_TRUE(next) << next.error().detail;
}

TEST(LinuxCncConnection, ARefusalSaysWhatWouldBeRight) {
  EXPECT_EQ(refusal("linuxcnc:10.0.0.7:5007"), "");
  EXPECT_EQ(refusal("linuxcnc:cnc.local?axes=ABC&enable=EMCTOO"), "");
  EXPECT_EQ(refusal("linuxcnc://[::1]:5007"), "");
  EXPECT_THAT(refusal("linuxcnc:"), HasSubstr("linuxcnc:HOST:5007"));
  EXPECT_THAT(refusal("linuxcnc:h:5007?axes=X,Y,U"), HasSubstr("none of the axes XYZABC"));
  EXPECT_THAT(refusal("linuxcnc:h:5007?enable=two words"), HasSubstr("without blanks"));
  EXPECT_THAT(refusal("linuxcnc:h:5007?pasword=x"), HasSubstr("did you mean 'password'"));
  EXPECT_THAT(refusal("linuxcnc:h:99999"), HasSubstr("99999"));
}

}  // namespace
}  // namespace sixdial::acquisition
