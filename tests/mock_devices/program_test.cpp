// The program sixdial-mock-rig from outside: its one line of JSON, its ports, its end.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/mock_devices/raw_port.h"
#include "tests/support/paths.h"

namespace sixdial::mock_devices {
namespace {

struct Program {
  explicit Program(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), test_paths::bin_dir() + "/sixdial-mock-rig");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe(ends.data()), 0);
    pid = ::fork();
    if (pid == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::dup2(ends[1], STDERR_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(ends[1]);
    output = ends[0];
  }
  ~Program() {
    if (pid > 0) {
      ::kill(pid, SIGKILL);
      ::waitpid(pid, nullptr, 0);
    }
    ::close(output);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::string line() const {
    std::string text;
    char c = 0;
    while (::read(output, &c, 1) == 1 && c != '\n') text += c;
    return text;
  }
  int wait() {
    int status = 0;
    ::waitpid(pid, &status, 0);
    pid = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  pid_t pid = -1;
  int output = -1;
};

using MockProgram = MockRigTest;

TEST_F(MockProgram, PrintsItsPortsServesAndEndsOnSigterm) {
  const std::string answer = (folder_ / "answer.json").string();
  Program program(
      {"--speed", "20", "--pty-dir", (folder_ / "ptys").string(), "--seed", "7", "--robot",
       "drawn", "--hide-seed", "5", "--reveal", answer});
  const std::string line = program.line();
  const auto ready = nlohmann::json::parse(line);
  EXPECT_EQ(ready["ready"], true);
  EXPECT_EQ(ready["serial"].size(), 7U);
  EXPECT_EQ(ready["speed"], 20.0);
  {
    Port dials(Port::tcp(ready["dial_port"].get<std::uint16_t>()));
    EXPECT_EQ(read_six(dials).size(), 6U);
    Port robot(Port::tcp(ready["robot_port"].get<std::uint16_t>()));
    EXPECT_EQ(robot_input(robot, 4), 0);
    Port mux(Port::serial(ready["serial"]["mux10"].get<std::string>()));
    mux.send("1\r");
    EXPECT_EQ(mux.line().size(), 13U);
  }
  // What is hidden is in the answer file and nowhere else.
  std::ifstream file(answer);
  const auto hidden = nlohmann::json::parse(file);
  ASSERT_EQ(hidden["effects"].size(), 1U);
  EXPECT_EQ(line.find(hidden["effects"][0]["cause"].get<std::string>()), std::string::npos);
  ASSERT_EQ(::kill(program.pid, SIGTERM), 0);
  EXPECT_EQ(program.wait(), 0);
  EXPECT_FALSE(
      std::filesystem::exists(std::filesystem::symlink_status(folder_ / "ptys" / "mux10")));
}

TEST_F(MockProgram, ServesAnArmUnderDrawWires) {
  const std::string rig = (folder_ / "arm.toml").string();
  const std::string answer = (folder_ / "arm.json").string();
  Program program(
      {"--robot", "serial", "--joints", "4", "--seed", "7", "--hide-seed", "5", "--reveal",
       answer, "--write-rig", rig});
  const auto ready = nlohmann::json::parse(program.line());
  EXPECT_EQ(ready["ready"], true);
  Port robot(Port::tcp(ready["robot_port"].get<std::uint16_t>()));
  EXPECT_EQ(robot_input(robot, 8), 0) << "status of a controller of four joints";
  EXPECT_EQ(robot_input(robot, 200), 4);
  Port wires(Port::tcp(ready["dial_port"].get<std::uint16_t>()));
  EXPECT_EQ(read_six(wires).size(), 6U);
  std::stringstream text;
  text << std::ifstream(rig).rdbuf();
  EXPECT_NE(text.str().find("kind = \"position\""), std::string::npos);
  std::ifstream file(answer);
  EXPECT_EQ(nlohmann::json::parse(file)["effects"].size(), 1U);
  ASSERT_EQ(::kill(program.pid, SIGTERM), 0);
  EXPECT_EQ(program.wait(), 0);
}

TEST_F(MockProgram, ServesAnotherControllerAndSaysHowToConnect) {
  const std::string rig = (folder_ / "rig.toml").string();
  const std::string line = (folder_ / "grbl").string();
  Program program({"--robot-controller", "grbl", "--robot-link", line, "--write-rig", rig});
  const auto ready = nlohmann::json::parse(program.line());
  const auto connection = ready["robot_connection"].get<std::string>();
  EXPECT_EQ(
      connection, "gcode-tcp:127.0.0.1:" + std::to_string(ready["robot_port"].get<int>()) +
                      "?dialect=grbl");
  EXPECT_EQ(ready["robot_serial_connection"], "gcode-serial:" + line + "?dialect=grbl");
  std::stringstream text;
  text << std::ifstream(rig).rdbuf();
  EXPECT_NE(text.str().find(connection), std::string::npos);
  Port grbl(Port::serial(line));
  grbl.send("?");
  const std::string status =
      grbl.read_until([](const std::string& got) { return got.ends_with(">\r\n"); });
  EXPECT_NE(status.find("<Idle|MPos:"), std::string::npos) << status;
  ASSERT_EQ(::kill(program.pid, SIGTERM), 0);
  EXPECT_EQ(program.wait(), 0);
}

TEST_F(MockProgram, AControllerThatCannotMoveAllJointsIsToldFromTheStart) {
  Program program(
      {"--robot", "serial", "--joints", "6", "--robot-controller", "klipper-socket"});
  const std::string line = program.line();
  EXPECT_NE(line.find("klipper-socket moves 3 axes at most"), std::string::npos) << line;
  EXPECT_EQ(program.wait(), 1);
}

TEST_F(MockProgram, SaysWhatIsWrongWithAnEffectAndFails) {
  Program program({"--hide", "joint_backlash:joint3:0.001"});
  const std::string line = program.line();
  EXPECT_NE(line.find("joint3"), std::string::npos) << line;
  EXPECT_NE(line.find("joint1 joint2"), std::string::npos) << line;
  EXPECT_EQ(program.wait(), 1);
}

}  // namespace
}  // namespace sixdial::mock_devices
