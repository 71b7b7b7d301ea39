// What goes into the package: example rigs for each connection, units, completion, man page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <set>
#include <sstream>

#include "acquisition/connection.h"
#include "acquisition/robot_driver.h"
#include "cli/cli.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "tests/support/figure.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using ::testing::HasSubstr;

const std::string kSource = test_paths::source_dir();

std::string printed(std::vector<const char*> words) {
  std::ostringstream out;
  std::ostringstream err;
  EXPECT_EQ(cli::run(static_cast<int>(words.size()), words.data(), out, err), 0) << err.str();
  return out.str();
}

TEST(ExampleRigs, EachConnectionHasOneAndEachLineOfItCanBeUsed) {
  std::set<std::string> kinds;
  int rigs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kSource + "/examples/rigs")) {
    SCOPED_TRACE(entry.path().string());
    const geometry::Rig rig = session::read_rig_file(entry.path().string());
    ASSERT_EQ(rig.dials.size(), 6U);
    std::set<std::string> places;
    for (const geometry::Dial& dial : rig.dials) {
      const auto connection = acquisition::parse_dial_connection(dial.connection);
      ASSERT_TRUE(connection) << connection.error();
      places.insert(dial.connection);
      if (const auto* serial = std::get_if<acquisition::SerialConnection>(&*connection)) {
        kinds.insert(std::string(serial->protocol->name));
        EXPECT_TRUE(serial->device.starts_with("/dev/serial/by-id/")) << "a stable name";
      } else {
        kinds.insert(dial.connection.substr(0, dial.connection.find(':')));
      }
    }
    EXPECT_EQ(places.size(), 6U) << "two dials in one place";
    EXPECT_TRUE(acquisition::robot_connection_of(rig));
    const std::string text = session::read_file(entry.path().string());
    EXPECT_TRUE(text.starts_with("# ")) << "commented";
    ++rigs;
  }
  EXPECT_EQ(rigs, 8) << "six connections, two other travels";
  EXPECT_EQ(
      kinds,
      (std::set<std::string>{"mahr", "modbus-rtu", "modbus-tcp", "mux10", "mw", "sylvac"}));
}

TEST(Manual, NamesEveryCommandOfTheTable) {
  const std::string page = printed({"sixdial", "manual"});
  EXPECT_TRUE(page.find(".TH SIXDIAL 1") != std::string::npos) << page.substr(0, 200);
  for (const char* command :
       {"sixdial session create", "sixdial collect", "sixdial calibrate", "sixdial doctor",
        "sixdial rig scan", "sixdial plan grid"}) {
    EXPECT_THAT(page, HasSubstr(std::string(".SS ") + command + "\n"));
  }
  EXPECT_THAT(page, HasSubstr("Exit codes: 0 ok"));
  // Each line that starts with a dot is a request that troff knows.
  std::istringstream lines(page);
  const std::set<std::string> known{".TH", ".SH", ".SS", ".TP", ".B", ".I", ".BR", ".\\\""};
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('.')) continue;
    EXPECT_TRUE(known.contains(line.substr(0, line.find(' ')))) << line;
  }
}

TEST(Completion, OffersCommandsAndOptionsInBash) {
  testing::TempDirectory directory;
  const std::string script = (directory.path() / "completion").string();
  std::ofstream(script) << printed({"sixdial", "completion"});
  const auto offered = [&](const std::string& words, int at, const std::string& more = "") {
    const std::string command = "bash -c '" + more + "source " + script + "; COMP_WORDS=(" +
                                words + "); COMP_CWORD=" + std::to_string(at) +
                                "; _sixdial; echo ${COMPREPLY[*]}' 2>&1";
    FILE* pipe = ::popen(command.c_str(), "r");
    std::array<char, 4096> text{};
    const std::size_t size = std::fread(text.data(), 1, text.size() - 1, pipe);
    ::pclose(pipe);
    return std::string(text.data(), size);
  };
  EXPECT_EQ(offered("sixdial do", 1), "doctor\n");
  EXPECT_THAT(offered("sixdial session cr", 2), HasSubstr("create"));
  EXPECT_THAT(offered("sixdial rig scan --no", 3), HasSubstr("--no-search"));
  EXPECT_THAT(offered("sixdial --json plan gr", 3), HasSubstr("grid"));

  // Names of sessions, from the service if one runs; files elsewhere.
  const std::string path = "PATH=" + test_paths::bin_dir() + ":$PATH; ";
  {
    testing::RunningService running;
    running.service().store().create_session(
        "monday", session::write_rig(geometry::default_rig()), {});
    const std::string with = "--socket " + running.socket_path().string();
    const auto asked = [&](const std::string& words, int at) {
      return offered("sixdial " + with + " " + words, at + 2, path);
    };
    EXPECT_EQ(asked("calibrate mo", 2), "monday\n");
    EXPECT_EQ(asked("session show mo", 3), "monday\n");
    EXPECT_EQ(asked("collect --session mo", 3), "monday\n");
    EXPECT_EQ(asked("session create mo", 3), "\n");
  }
  EXPECT_EQ(offered("sixdial calibrate mo", 2, path + "SIXDIAL_SOCKET=/none; "), "\n");
  EXPECT_EQ(
      offered("sixdial plan grid --rig " + directory.path().string() + "/comp", 4),
      script + "\n");
}

TEST(Units, GiveTheSocketToItsGroupAndEndInTime) {
  const std::string socket = session::read_file(kSource + "/packaging/systemd/sixdiald.socket");
  EXPECT_THAT(socket, HasSubstr("ListenStream=/run/sixdial/sixdiald.sock"));
  EXPECT_THAT(socket, HasSubstr("SocketMode=0660"));
  const std::string own =
      session::read_file(kSource + "/packaging/systemd/user/sixdiald.socket");
  EXPECT_THAT(own, HasSubstr("SocketMode=0600"));
  EXPECT_THAT(own, HasSubstr("ListenStream=%t/sixdial/sixdiald.sock"));
  const std::string service =
      session::read_file(kSource + "/packaging/systemd/sixdiald.service");
  EXPECT_THAT(service, HasSubstr("Requires=sixdiald.socket"));
  EXPECT_THAT(service, HasSubstr("StateDirectory=sixdial"));
}

struct Ran {
  int code = -1;
  std::string said;
};

Ran run_program(const std::string& command) {
  Ran ran;
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> piece{};
  for (std::size_t size = 0; (size = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) {
    ran.said.append(piece.data(), size);
  }
  ran.code = ::pclose(pipe);
  return ran;
}

/// The units of a folder with the program of this build in them.
void copy_units(const std::string& from, const std::filesystem::path& to) {
  std::filesystem::create_directories(to);
  for (const char* name : {"sixdiald.service", "sixdiald.socket"}) {
    std::string text = session::read_file(from + "/" + name);
    const std::string start = "ExecStart=sixdiald";
    if (const std::size_t at = text.find(start); at != std::string::npos) {
      text.replace(
          at, start.size(), std::string("ExecStart=") + test_paths::bin_dir() + "/sixdiald");
    }
    std::ofstream(to / name) << text;
  }
}

TEST(Units, AreUnderstoodBySystemdWithoutAWord) {
  testing::TempDirectory directory;
  const std::string place = directory.path().string();
  copy_units(kSource + "/packaging/systemd", place + "/system");
  copy_units(kSource + "/packaging/systemd/user", place + "/user");
  const Ran system = run_program(
      "systemd-analyze verify --man=no " + place + "/system/sixdiald.service " + place +
      "/system/sixdiald.socket");
  EXPECT_EQ(system.code, 0) << system.said;
  EXPECT_EQ(system.said, "");
  const Ran user = run_program(
      "XDG_RUNTIME_DIR=" + place + " systemd-analyze --user verify --man=no " + place +
      "/user/sixdiald.service " + place + "/user/sixdiald.socket");
  EXPECT_EQ(user.code, 0) << user.said;
  EXPECT_EQ(user.said, "");
}

TEST(Units, ExposeLittleByTheCountOfSystemd) {
  constexpr double kMost = 3.0;  // of 10; systemd calls up to 4.9 "OK"
  const Ran ran = run_program(
      "systemd-analyze security --offline=yes --no-pager " + kSource +
      "/packaging/systemd/sixdiald.service");
  const std::string before = "Overall exposure level for sixdiald.service: ";
  const std::size_t at = ran.said.find(before);
  ASSERT_NE(at, std::string::npos) << ran.said;
  const double exposure = std::stod(ran.said.substr(at + before.size()));
  test::figure("package.exposure", exposure);
  EXPECT_LE(exposure, kMost) << ran.said;
}

TEST(Manual, OfEachProgramIsRoffThatManUnderstands) {
  for (const char* command :
       {"/sixdial manual", "/sixdiald --print-manual", "/sixdial-mock-rig --print-manual"}) {
    SCOPED_TRACE(command);
    const Ran page = run_program(test_paths::bin_dir() + command);
    EXPECT_EQ(page.code, 0);
    EXPECT_THAT(page.said, HasSubstr(".SH NAME\nsixdial"));
    EXPECT_THAT(page.said, HasSubstr(".SH OPTIONS\n"));
    std::istringstream lines(page.said);
    const std::set<std::string> known{".TH", ".SH", ".SS", ".TP", ".B", ".I", ".BR", ".\\\""};
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with('.')) continue;
      EXPECT_TRUE(known.contains(line.substr(0, line.find(' ')))) << line;
    }
  }
  const Ran mock = run_program(test_paths::bin_dir() + "/sixdial-mock-rig --print-manual");
  EXPECT_THAT(mock.said, HasSubstr("\\-\\-pty\\-dir"));
  EXPECT_EQ(mock.said.find("sixdial.db"), std::string::npos) << "it has no database";
}

}  // namespace
}  // namespace sixdial::cli
