// Robots that a command of the user's own moves: real programs, real exit codes.
#include "acquisition/robots/exec_robot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "acquisition/robot_driver.h"
#include "acquisition/robots/exec_command.h"
#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDeg = std::numbers::pi / 180.0;
const std::vector<RobotJoint> kJoints{{"q1", true}, {"slide", false}};

class ExecRobotTest : public testing::Test {
 protected:
  /// A script in this test's folder.
  std::string script(const std::string& text) {
    const std::string path = folder_.path("move.sh");
    std::ofstream(path) << "#!/bin/sh\n" << text;
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  }
  std::unique_ptr<RobotPort> robot(const std::string& command) {
    const auto connection = parse_robot_connection("exec:" + command, kJoints);
    EXPECT_TRUE(connection) << connection.error();
    EXPECT_TRUE(connection->driver->runs_programs);
    return connection->open({.clock = clock_});
  }
  std::string noted(const std::string& name = "noted") const {
    std::stringstream text;
    text << std::ifstream(folder_.path(name)).rdbuf();
    return text.str();
  }
  test::TemporaryFolder folder_;
  SystemClock clock_;
};

TEST_F(ExecRobotTest, TheCommandSeesTheTargetAndSaysWhereItIs) {
  const auto port = robot(
      script(
          "echo \"$@\" > '" + folder_.path("noted") +
          "'\necho moving\necho q1_deg=28.65\necho slide_mm = 99.5\necho "
          "temperature_c=21.5\n") +
      " --to {q1_deg} {slide_mm} {q1_rad}");
  EXPECT_EQ(port->state({})->motion, Motion::kIdle);
  const auto there = port->move_to(Eigen::Vector2d(0.5, 100.0), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_EQ(noted(), "--to 28.647889757 100.000000000 0.500000000\n");
  EXPECT_NEAR(there->q[0], 28.65 * kDeg, 1e-12);
  EXPECT_EQ(there->q[1], 99.5);
  EXPECT_EQ(there->temperature_c, 21.5);
  EXPECT_EQ(there->motion, Motion::kInPosition);
  EXPECT_EQ(port->state({})->q, there->q);
}

TEST_F(ExecRobotTest, ACommandThatPrintsNoValueIsWhereItWasSent) {
  const auto port = robot(script("exit 0\n") + " {q1_deg} {slide_mm}");
  const auto there = port->move_to(Eigen::Vector2d(0.5, 100.0), 10s, {});
  ASSERT_TRUE(there) << there.error().detail;
  EXPECT_EQ(there->q, Eigen::VectorXd(Eigen::Vector2d(0.5, 100.0)));
}

TEST_F(ExecRobotTest, ExitCodesSayWhatBecameOfIt) {
  const auto port =
      robot(script("echo \"no path to $1\" >&2\nexit $1\n") + " 10 {q1_deg}{slide_mm}");
  const auto unreachable = port->move_to(Eigen::Vector2d(0, 0), 10s, {});
  ASSERT_FALSE(unreachable);
  EXPECT_EQ(unreachable.error().kind, RobotFaultKind::kUnreachable);
  const auto broken =
      robot(script("echo one >&2\necho 'the arm is off' >&2\nexit 3\n") + " {q1_deg}{slide_mm}")
          ->move_to(Eigen::Vector2d(0, 0), 10s, {});
  EXPECT_EQ(broken.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(broken.error().detail, HasSubstr("ended with 3"));
  EXPECT_THAT(broken.error().detail, HasSubstr("the arm is off"));
  const auto killed = robot(script("kill -9 $$\n") + " {q1_deg}{slide_mm}")
                          ->move_to(Eigen::Vector2d(0, 0), 10s, {});
  EXPECT_EQ(killed.error().kind, RobotFaultKind::kHalted);
  const auto missing = robot(folder_.path("nobody") + " {q1_deg}{slide_mm}")
                           ->move_to(Eigen::Vector2d(0, 0), 10s, {});
  EXPECT_EQ(missing.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(missing.error().detail, HasSubstr("No such file"));
}

TEST_F(ExecRobotTest, WhatItPrintsWrongIsNoPosition) {
  for (const char* const out :
       {"echo q1_deg=abc", "echo q1_deg=1; echo q1_deg=2; echo slide_mm=0", "echo q1_deg=nan",
        "echo q1_deg=12.5", "echo q1_deg=", "echo temperature_c=warm"}) {
    const auto wrong = robot(script(std::string(out) + "\n") + " {q1_deg} {slide_mm}")
                           ->move_to(Eigen::Vector2d(0, 0), 10s, {});
    ASSERT_FALSE(wrong) << out;
    EXPECT_EQ(wrong.error().kind, RobotFaultKind::kController) << out;
  }
}

// What stands in the rig file reaches the program as it is, whatever a shell would make of it.
TEST_F(ExecRobotTest, NoShellReadsTheCommand) {
  const std::string trap = folder_.path("trap");
  const auto port = robot(
      script("printf '%s\\n' \"$@\" > '" + folder_.path("noted") + "'\n") + " \"$(touch " +
      trap + ")\" '`touch " + trap + "`' $HOME *;touch {q1_deg}{slide_mm}");
  ASSERT_TRUE(port->move_to(Eigen::Vector2d(0, 0), 10s, {}));
  EXPECT_EQ(
      noted(),
      "$(touch " + trap + ")\n`touch " + trap + "`\n$HOME\n*;touch\n0.0000000000.000000000\n");
  EXPECT_FALSE(std::filesystem::exists(trap));
}

TEST_F(ExecRobotTest, TheProgramSeesASmallEnvironmentAndNoFileOfThisProcess) {
  ::setenv("SIXDIAL_TEST_SECRET", "do not tell", 1);
  const int open_here = ::dup(0);  // without O_CLOEXEC
  const auto port = robot(
      script(
          "env > '" + folder_.path("noted") + "'\nls /proc/self/fd > '" +
          folder_.path("files") + "'\n") +
      " {q1_deg} {slide_mm}");
  ASSERT_TRUE(port->move_to(Eigen::Vector2d(0, 0), 10s, {}));
  ::close(open_here);
  ::unsetenv("SIXDIAL_TEST_SECRET");
  EXPECT_THAT(noted(), testing::Not(HasSubstr("SECRET")));
  EXPECT_THAT(noted(), HasSubstr("PATH="));
  std::stringstream files(noted("files"));
  int count = 0;
  for (std::string line; std::getline(files, line);) ++count;
  EXPECT_EQ(count, 4) << "in, out, error, and the folder that ls reads: " << files.str();
}

TEST_F(ExecRobotTest, AMoveThatIsStoppedOrLateIsKilledWithAllThatItStarted) {
  const std::string alive = folder_.path("alive");
  const auto port = robot(
      script(
          "(while :; do date > '" + alive + "'; sleep 0.05; done) &\ntrap 'echo term >> \"" +
          folder_.path("noted") + "\"; exit 1' TERM\nwhile :; do sleep 0.05; done\n") +
      " {q1_deg} {slide_mm}");
  const auto still_writes = [&] {
    std::filesystem::remove(alive);
    std::this_thread::sleep_for(400ms);
    return std::filesystem::exists(alive);
  };
  std::stop_source stop;
  std::jthread stopper([&] {
    EXPECT_TRUE(test::eventually([&] { return std::filesystem::exists(alive); }));
    stop.request_stop();
  });
  const auto stopped = port->move_to(Eigen::Vector2d(0, 0), 600s, stop.get_token());
  EXPECT_EQ(stopped.error().kind, RobotFaultKind::kCancelled);
  EXPECT_EQ(noted(), "term\n") << "it is asked before it is killed";
  EXPECT_FALSE(still_writes());
  const auto late = port->move_to(Eigen::Vector2d(0, 0), 300ms, {});
  EXPECT_EQ(late.error().kind, RobotFaultKind::kNotThere);
  EXPECT_FALSE(still_writes());
}

TEST_F(ExecRobotTest, AHaltEndsTheCommandAndOneThatIgnoresItIsKilled) {
  const auto port =
      robot(script("trap '' TERM\nwhile :; do sleep 0.05; done\n") + " {q1_deg} {slide_mm}");
  EXPECT_FALSE(port->halt({})) << "nothing runs";
  std::jthread person(
      [&] { EXPECT_TRUE(test::eventually([&] { return port->halt({}).has_value(); })); });
  const auto halted = port->move_to(Eigen::Vector2d(0, 0), 600s, {});
  ASSERT_FALSE(halted);
  EXPECT_EQ(halted.error().kind, RobotFaultKind::kHalted);
  EXPECT_EQ(port->state({})->motion, Motion::kFault);
  EXPECT_EQ(port->state({})->q.size(), 0) << "nobody knows where it is";
}

TEST_F(ExecRobotTest, SignalsReachAScriptOfAProcessThatBlocksThem) {
  sigset_t term;
  sigset_t before;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &term, &before);
  const auto port = robot(script("kill -TERM $$\nsleep 5\n") + " {q1_deg} {slide_mm}");
  const auto ended = port->move_to(Eigen::Vector2d(0, 0), 20s, {});
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, RobotFaultKind::kHalted) << ended.error().detail;
}

TEST_F(ExecRobotTest, MoreOutputThanAPipeHoldsDoesNotBlockIt) {
  const auto port = robot(
      script("i=0\nwhile [ $i -lt 20000 ]; do echo 'a line that says nothing'; i=$((i+1)); "
             "done\n") +
      " {q1_deg} {slide_mm}");
  EXPECT_TRUE(port->move_to(Eigen::Vector2d(0, 0), 60s, {}));
}

TEST_F(ExecRobotTest, TheSpeedIsSetOnlyWhereTheCommandSaysIt) {
  const auto deaf = robot(script("") + " {q1_deg} {slide_mm}");
  EXPECT_EQ(deaf->speed({}).value(), std::nullopt);
  EXPECT_FALSE(deaf->set_speed(10, {}));
  const auto port = robot(
      script("echo $3 > '" + folder_.path("noted") + "'\n") +
      " {q1_deg} {slide_mm} {speed_percent}");
  ASSERT_TRUE(port->set_speed(10, {}));
  ASSERT_TRUE(port->move_to(Eigen::Vector2d(0, 0), 10s, {}));
  EXPECT_EQ(noted(), "10\n");
}

TEST(ExecCommand, WordsAreCutAtBlanksAndQuotationsKeepThem) {
  EXPECT_THAT(
      exec_words("/bin/move  \"two words\" 'a \"b\"' {q1_deg},{slide_mm}", kJoints).value(),
      ElementsAre("/bin/move", "two words", "a \"b\"", "{q1_deg},{slide_mm}"));
  const auto refusal = [](std::string_view text) {
    const auto words = exec_words(text, kJoints);
    return words ? "" : words.error();
  };
  EXPECT_THAT(refusal(""), HasSubstr("no program"));
  EXPECT_THAT(refusal("move {q1_deg}"), HasSubstr("never says joint slide"));
  EXPECT_THAT(refusal("move {q1_deg} {q3_deg}"), HasSubstr("{q3_deg} is no joint"));
  EXPECT_THAT(refusal("move {q1_mm} {slide_mm}"), HasSubstr("{q1_mm} is no joint"))
      << "it turns";
  EXPECT_THAT(refusal("move {q1_deg {slide_mm}"), HasSubstr("never closed"));
  EXPECT_THAT(refusal("move {q1_deg} {slide_mm} {"), HasSubstr("never closed"));
  EXPECT_THAT(refusal("move 'x {q1_deg} {slide_mm}"), HasSubstr("never closed"));
  EXPECT_THAT(refusal("{q1_deg} {slide_mm}"), HasSubstr("own name"));
  EXPECT_THAT(refusal("move {q1_deg} {slide_mm} | tee log"), HasSubstr("script"));
  EXPECT_THAT(refusal("move\n{q1_deg} {slide_mm}"), HasSubstr("control character"));
}

// A URDF may call its second joint q1.
TEST(ExecCommand, AJointsOwnNameGoesBeforeItsNumber) {
  const std::vector<RobotJoint> joints{{"shoulder", true}, {"q1", true}};
  const auto words = exec_words("move {q1_rad} {shoulder_rad}", joints);
  ASSERT_TRUE(words) << words.error();
  EXPECT_THAT(
      filled_in(*words, joints, Eigen::Vector2d(1, 2), 100),
      ElementsAre("move", "2.000000000", "1.000000000"));
}

}  // namespace
}  // namespace sixdial::acquisition
