// Files and streams that are not as a program would like them: a full disk behind standard
// output, links, pipes, control bytes in what is quoted, a run that hears no signal.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "cli/printable.h"
#include "session/csv.h"
#include "tests/support/command_line.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;

using testing::eventually;
using ::testing::HasSubstr;
using testing::TempDirectory;

const std::string kBin = test_paths::bin_dir();
const std::string kBundle = test_paths::test_data() + "/session_00";

int exit_code_of(const std::string& shell_command) {
  const int status = std::system(shell_command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(StandardOutput, AFullDiskIsAFailureOfEveryProgram) {
  const std::vector<std::string> commands{
      "sixdial --help",
      "sixdial plan random --rig " + kBundle + "/rig.toml --count 5",
      "sixdial rig draw " + kBundle + "/rig.toml",
      "sixdial protocol",
      "sixdial --json protocol",
      "sixdiald --print-protocol",
      "sixdiald --help",
      "sixdial-mock-rig --print-manual",
      "sixdial-mock-rig --help"};
  for (const std::string& words : commands) {
    EXPECT_EQ(exit_code_of(kBin + "/" + words + " > /dev/full 2> /dev/null"), 1) << words;
    EXPECT_EQ(exit_code_of(kBin + "/" + words + " > /dev/null 2> /dev/null"), 0) << words;
  }
}

class Output : public ::testing::Test {
 protected:
  Outcome drawn_to(const std::filesystem::path& path) {
    return sixdial({"rig", "draw", kBundle + "/rig.toml", "-o", path.string()});
  }
  TempDirectory directory_;
};

TEST_F(Output, IsWrittenThroughLinksAndKeepsTheRightsOfTheFile) {
  const auto real = directory_.path() / "real.svg";
  const auto link = directory_.path() / "link.svg";
  const auto second = directory_.path() / "second.svg";
  std::ofstream(real) << "old";
  ASSERT_EQ(::chmod(real.c_str(), 0640), 0);
  std::filesystem::create_symlink("real.svg", link);
  std::filesystem::create_symlink(link, second);
  EXPECT_EQ(drawn_to(second).code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(second));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_THAT(session::read_file(real.string()), HasSubstr("<svg"));
  EXPECT_EQ(std::filesystem::status(real).permissions(), std::filesystem::perms{0640});
  // A link to a file that is not there yet makes it.
  const auto dangling = directory_.path() / "dangling.svg";
  std::filesystem::create_symlink(directory_.path() / "made.svg", dangling);
  EXPECT_EQ(drawn_to(dangling).code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(dangling));
  EXPECT_TRUE(std::filesystem::is_regular_file(directory_.path() / "made.svg"));
}

TEST_F(Output, IsRefusedWhereThereIsNoPlainFile) {
  const auto pipe = directory_.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::create_symlink(pipe, directory_.path() / "to-pipe");
  std::filesystem::create_symlink("/dev/null", directory_.path() / "to-null");
  for (const auto& [name, kind] : std::vector<std::pair<std::string, std::string>>{
           {"pipe", "a pipe"},
           {"to-pipe", "a pipe"},
           {"to-null", "a device"},
           {"", "a folder"}}) {
    const auto path = name.empty() ? directory_.path() : directory_.path() / name;
    const Outcome outcome = drawn_to(path);
    EXPECT_NE(outcome.code, 0) << path;
    EXPECT_THAT(outcome.err, HasSubstr(path.string() + ": is " + kind + ", not a plain file"));
  }
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(RoughFiles, WhatTheKernelMakesOrNeverEndsIsNotRead) {
  TempDirectory directory;
  std::filesystem::copy_file(kBundle + "/rig.toml", directory.path() / "rig.toml");
  const auto csv = directory.path() / "session.csv";
  for (const auto& [target, kind] : std::vector<std::pair<std::string, std::string>>{
           {"/proc/kmsg", "made by the kernel"},
           {"/proc/self/maps", "made by the kernel"},
           {"/dev/zero", "a device"}}) {
    std::filesystem::remove(csv);
    std::filesystem::create_symlink(target, csv);
    const Outcome outcome =
        sixdial({"calibrate", directory.path().string(), "-q", "--method", "lm"});
    EXPECT_EQ(outcome.code, 5) << target;
    const bool may_open = ::access(target.c_str(), R_OK) == 0;  // kmsg is root's
    if (may_open) {
      EXPECT_THAT(outcome.err, HasSubstr("is " + kind + ", not a plain file")) << target;
    }
  }
  std::filesystem::remove(csv);
  std::ofstream(csv) << "set,point\n";
  std::filesystem::resize_file(csv, std::uintmax_t{5} << 30);  // a hole: it takes no room
  EXPECT_THAT(
      sixdial({"calibrate", directory.path().string(), "-q"}).err,
      HasSubstr("is larger than 4 GiB"));
}

/// What a terminal would take for more than letters.
bool has_control_bytes(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto code = static_cast<unsigned char>(text[i]);
    if ((code < 0x20 && code != '\n' && code != '\t') || code == 0x7f) return true;
    if (code == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0) {
      return true;
    }
  }
  return false;
}

/// Retitle, colour, ask for an answer, ring, rub out, and the same in two bytes of UTF-8.
const std::string kEvil =
    "a\x1b]0;owned\x07"
    "b\x1b[31m\x1b[6n\x7f\r\xc2\x9b"
    "2J";

TEST(ControlBytes, OfFilesAndArgumentsReachNoTerminal) {
  TempDirectory directory;
  const std::string rig = session::read_file(kBundle + "/rig.toml");
  const std::string csv = session::read_file(kBundle + "/session.csv");
  const auto bundle = [&](const std::string& name, const std::string& rig_text,
                          const std::string& csv_text) {
    const auto folder = directory.path() / name;
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "rig.toml") << rig_text;
    std::ofstream(folder / "session.csv") << csv_text;
    return folder.string();
  };
  std::string odd_set = csv;
  odd_set.replace(odd_set.find("\nG1,") + 1, 2, kEvil);
  std::string odd_number = csv;
  odd_number.replace(odd_number.find("\nG1,") + 4, 1, "," + kEvil + ",");
  std::string odd_header = csv;
  odd_header.replace(0, 3, kEvil);
  std::string odd_key = "\"\\u001b[31mkey\" = 1\n" + rig;
  const auto plan = directory.path() / "plan.csv";
  std::ofstream(plan) << "set,point,target_x_mm,target_y_mm\n" << kEvil << ",0,28,48\n";
  const auto result = directory.path() / "result.json";
  std::ofstream(result) << "{\"" << kEvil << "\": 1}";
  const std::vector<std::vector<std::string>> commands{
      {"compensate", bundle("number", rig, odd_number), "--target", "28,45"},
      {"compensate", bundle("header", rig, odd_header), "--target", "28,45"},
      {"compensate", bundle("key", odd_key, csv), "--target", "28,45"},
      {"compensate", kBundle, "--calibration-method", "lm", "--plan", plan.string()},
      {"compensate", kBundle, "--calibration", result.string(), "--target", "28,45"},
      {"calibrate", bundle("set", rig, odd_set), "--method", "lm"},
      {"calibrate", "/" + kEvil},
      {"calibrate", kBundle, "--method", kEvil},
      {kEvil},
      {"session", "show", kEvil, "--socket", "/" + kEvil}};
  for (std::vector<std::string> words : commands) {
    for (const bool json : {false, true}) {
      if (json) words.emplace_back("--json");
      const Outcome outcome = sixdial(words);
      // A plan on stdout is data, which only a terminal gets as text: see for_terminal.
      const bool data = words.size() > 4 && words[4] == "--plan" && !json;
      if (!data) {
        EXPECT_FALSE(has_control_bytes(outcome.out))
            << words[0] << ' ' << words[1] << outcome.out;
      }
      EXPECT_FALSE(has_control_bytes(outcome.err)) << words[0] << outcome.err;
    }
  }
}

TEST(ControlBytes, AreSpeltOutAndLettersStay) {
  EXPECT_EQ(for_terminal("a\x1b[1m\xc2\x9b\x7f\r\n\tµm °"), "a\\x1b[1m\\x9b\\x7f\\r\n\tµm °");
  EXPECT_EQ(for_terminal(std::string("\xff\x00", 2)), "??");
  EXPECT_EQ(json_for_terminal("{\"a\":\"\xc2\x9b\x7f µ\"}"), "{\"a\":\"\\u009b\\u007f µ\"}");
  EXPECT_FALSE(has_control_bytes(for_terminal(kEvil)));
  // What turns the order of letters round lets a name look like another.
  EXPECT_EQ(for_terminal("a\u202eb\u2066c\u200fd – €"), "a\\u202eb\\u2066c\\u200fd – €");
  EXPECT_EQ(json_for_terminal("\"a\u202eb\""), "\"a\\u202eb\"");
}

TEST(Seeds, AreWholeNumbersFromZeroOn) {
  for (const std::string seed : {"-1", "1.5", "1e3", "99999999999999999999", "x", ""}) {
    const Outcome outcome = sixdial(
        {"plan", "random", "--rig", kBundle + "/rig.toml", "--count", "2", "--seed", seed});
    EXPECT_EQ(outcome.code, 2) << seed;
    EXPECT_TRUE(outcome.out.empty()) << seed;
  }
  for (const char* command : {"calibrate", "compare", "diagnose", "report"}) {
    const Outcome outcome = sixdial({command, kBundle, "--seed", "-1"});
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_THAT(outcome.err, HasSubstr("whole number from 0")) << command;
  }
  EXPECT_EQ(
      exit_code_of(kBin + "/sixdial-mock-rig --seed -1 > /dev/null 2>&1 < /dev/null"), 105)
      << "a validator's code of CLI11";
}

/// A program that was started with a pipe as one of its files, which nobody writes into.
class Waiting {
 public:
  explicit Waiting(std::vector<std::string> words) {
    if (::pipe(silent_.data()) != 0) throw std::runtime_error("no pipe");
    for (std::string& word : words) {
      if (word == "SILENT") word = "/dev/fd/" + std::to_string(silent_[0]);
    }
    pid_ = ::fork();
    if (pid_ == 0) {
      std::vector<char*> arguments;
      for (std::string& word : words) arguments.push_back(word.data());
      arguments.push_back(nullptr);
      ::close(silent_[1]);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
  }
  ~Waiting() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    ::close(silent_[0]);
    ::close(silent_[1]);
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
  /// It sleeps in the reading of the pipe.
  [[nodiscard]] bool reads() const {
    std::ifstream about("/proc/" + std::to_string(pid_) + "/wchan");
    std::string where;
    return static_cast<bool>(about >> where) && where.find("pipe") != std::string::npos;
  }
  int ended_by(int signal) {
    ::kill(pid_, signal);
    int status = -1;
    if (eventually([&] { return ::waitpid(pid_, &status, WNOHANG) == pid_; })) pid_ = -1;
    return status;
  }

 private:
  std::array<int, 2> silent_{};
  pid_t pid_ = -1;
};

TEST(Interruption, EndsAProgramThatWaitsForAFile) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Waiting program(
        {kBin + "/sixdial", "compensate", kBundle, "--calibration-method", "lm", "--plan",
         "SILENT"});
    ASSERT_TRUE(eventually([&] { return program.reads(); }))
        << "it does not wait for the file, or this kernel does not tell where a process waits";
    const int status = program.ended_by(signal);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
  }
}

}  // namespace
}  // namespace sixdial::cli
