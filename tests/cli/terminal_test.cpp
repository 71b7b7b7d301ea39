// The programs in a real (pseudo) terminal: progress in place and never wrapped, narrow, made
// narrower while it runs, without colour on request, ended by Ctrl-C.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <optional>
#include <sstream>

#include "cli/collect_screen.h"
#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using ::testing::HasSubstr;
using testing::kPatience;
using ::testing::Not;

const std::string kBundle = test_paths::test_data() + "/session_00";
const std::string kBin = test_paths::bin_dir();

/// As much of a terminal as the programs use: letters, \r, \n, wrapping, clearing, cursor up,
/// and nothing of a synchronized change before its end.
class Emulator {
 public:
  Emulator(std::size_t columns, std::size_t rows) : columns_(columns), rows_(rows) {
    screen_.emplace_back();
  }
  void take(const std::string& bytes) {
    pending_ += bytes;
    std::size_t at = 0;
    for (; at < pending_.size(); ++at) {
      const char c = pending_[at];
      if (c == '\x1b') {
        const std::size_t end = pending_.find_first_of("ABCDHJKmhl", at);
        if (end == std::string::npos) break;  // the rest has yet to come
        escape(pending_.substr(at, end - at + 1));
        at = end;
      } else if (c == '\r') {
        column_ = 0;
      } else if (c == '\n') {
        next_row();
      } else if ((c & 0xC0) != 0x80) {
        letter(c);
      }
    }
    pending_.erase(0, at);
  }
  /// What the terminal shows, the newest lines.
  [[nodiscard]] std::string text() const {
    return before_change_ ? before_change_->substr(before_top_) : from(top());
  }
  /// And the lines above it that have rolled out of sight.
  [[nodiscard]] std::string everything() const { return before_change_.value_or(from(0)); }
  [[nodiscard]] std::size_t wrapped() const { return wrapped_; }
  /// As terminals do after a while if a change's end does not come.
  void end_change() { before_change_.reset(); }

 private:
  [[nodiscard]] std::string from(std::size_t first) const {
    std::string all;
    for (std::size_t i = first; i < screen_.size(); ++i) all += screen_[i] + "\n";
    return all;
  }
  [[nodiscard]] std::size_t top() const {
    return screen_.size() > rows_ ? screen_.size() - rows_ : 0;
  }
  void letter(char c) {
    if (column_ >= columns_) {
      ++wrapped_;
      next_row();
      column_ = 0;
    }
    std::string& line = screen_[row_];
    if (line.size() <= column_) line.resize(column_ + 1, ' ');
    line[column_++] = c;
  }
  void next_row() {
    ++row_;
    if (row_ >= screen_.size()) screen_.emplace_back();
  }
  void escape(const std::string& sequence) {
    const auto count = static_cast<std::size_t>(std::max(
        1, std::atoi(sequence.substr(std::min<std::size_t>(2, sequence.size())).c_str())));
    if (sequence == "\x1b[?2026h") {
      before_change_ = from(0);
      before_top_ = before_change_->size() - from(top()).size();
    } else if (sequence == "\x1b[?2026l") {
      before_change_.reset();
    } else if (sequence.back() == 'A') {
      row_ = row_ >= top() + count ? row_ - count : top();  // never above the terminal's top
    } else if (sequence.back() == 'K') {
      screen_[row_].resize(std::min(screen_[row_].size(), column_));
    } else if (sequence.back() == 'J') {
      screen_[row_].resize(std::min(screen_[row_].size(), column_));
      screen_.resize(row_ + 1);
    }
  }
  std::size_t columns_, rows_, row_ = 0, column_ = 0, wrapped_ = 0;
  std::vector<std::string> screen_;
  std::string pending_;
  std::optional<std::string> before_change_;  // what is shown while a change is under way
  std::size_t before_top_ = 0;
};

/// A program in a terminal of this size.
class InTerminal {
 public:
  InTerminal(
      std::vector<std::string> words, std::uint16_t columns, std::uint16_t rows,
      const std::string& variable = "")
      : emulator_(columns, rows) {
    winsize size{.ws_row = rows, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_ = ::forkpty(&terminal_, nullptr, nullptr, &size);
    if (pid_ == 0) {
      ::unsetenv("NO_COLOR");
      if (!variable.empty()) ::putenv(const_cast<char*>(variable.c_str()));
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
  }
  ~InTerminal() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    ::close(terminal_);
  }
  InTerminal(const InTerminal&) = delete;
  InTerminal& operator=(const InTerminal&) = delete;

  /// Reads on until the screen satisfies it; false after a while, or where the program ended.
  bool until(const std::function<bool(const std::string&)>& satisfied) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!satisfied(emulator_.text())) {
      if (std::chrono::steady_clock::now() > end || !read_some())
        return satisfied(emulator_.text());
    }
    return true;
  }
  bool until_text(const std::string& text) {
    return until(
        [&](const std::string& screen) { return screen.find(text) != std::string::npos; });
  }
  void type(const std::string& keys) {
    ASSERT_EQ(::write(terminal_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  void resize(std::uint16_t columns, std::uint16_t rows) {
    const winsize size{.ws_row = rows, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
    ::ioctl(terminal_, TIOCSWINSZ, &size);
  }
  /// Its exit code, after everything it printed was read.
  int wait() {
    auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      const std::size_t before = all_.size();
      if (!read_some()) break;
      if (all_.size() > before) end = std::chrono::steady_clock::now() + kPatience;
    }
    emulator_.end_change();
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  [[nodiscard]] const Emulator& screen() const { return emulator_; }
  [[nodiscard]] const std::string& all() const { return all_; }

 private:
  bool read_some() {
    pollfd ready{.fd = terminal_, .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, 200) <= 0) return true;
    std::string bytes(65536, '\0');
    const ssize_t size = ::read(terminal_, bytes.data(), bytes.size());
    if (size <= 0) return false;
    bytes.resize(static_cast<std::size_t>(size));
    all_ += bytes;
    emulator_.take(bytes);
    return true;
  }
  Emulator emulator_;
  std::string all_;
  int terminal_ = -1;
  pid_t pid_ = -1;
};

/// Without what steers the terminal.
std::vector<std::string> lines_of(const std::string& bytes) {
  std::vector<std::string> lines(1);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (bytes[i] == '\x1b') {
      i = bytes.find_first_of("ABCDHJKmhl", i);
      if (i == std::string::npos) break;
    } else if (bytes[i] == '\n' || bytes[i] == '\r') {
      lines.emplace_back();
    } else {
      lines.back() += bytes[i];
    }
  }
  return lines;
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + 1)) {
    ++count;
  }
  return count;
}

/// How many samples the estimate on the screen is made of; 0: there is none.
int samples_told(const std::string& screen) {
  const std::string words = "estimate after ";
  const std::size_t at = screen.rfind(words);
  return at == std::string::npos ? 0 : std::atoi(screen.c_str() + at + words.size());
}

TEST(Terminal, EveryCalculationShowsABarInPlaceThatGoesAwayAtItsEnd) {
  const std::vector<std::vector<std::string>> calculations{
      {kBin + "/sixdial", "calibrate", kBundle, "--qpso1-iterations", "10",
       "--qpso2-iterations", "40", "--anfis-epochs", "10"},
      {kBin + "/sixdial", "compare", kBundle, "--methods", "before,lm,ekf_dqpso",
       "--qpso1-iterations", "10", "--qpso2-iterations", "40"},
      {kBin + "/sixdial", "diagnose", kBundle, "--bootstrap", "0", "--no-gain"},
      {kBin + "/sixdial", "compensate", kBundle, "--target", "28,48"}};
  for (const auto& words : calculations) {
    InTerminal run(words, 60, 24);
    EXPECT_EQ(run.wait(), 0) << run.screen().text();
    EXPECT_THAT(run.all(), HasSubstr("[")) << words[1];
    EXPECT_THAT(run.all(), HasSubstr(".] ")) << words[1];
    EXPECT_THAT(run.screen().text(), Not(HasSubstr(".] "))) << run.screen().text();
  }
}

TEST(Terminal, CtrlCEndsACalculationAndSaysWhatIsKept) {
  for (const char* verb : {"calibrate", "compare"}) {
    InTerminal run(
        {kBin + "/sixdial", verb, kBundle, "--particles", "2000", "--qpso1-iterations",
         "100000"},
        60, 24);
    EXPECT_TRUE(run.until_text(".] ")) << run.screen().text();
    run.type("\x03");
    EXPECT_EQ(run.wait(), 130);
    EXPECT_THAT(run.screen().text(), HasSubstr("nothing of it is kept")) << verb;
  }
}

TEST(Terminal, CtrlCLeavesAJobOfTheServiceRunningAndSaysSo) {
  testing::RunningService running;
  auto client = running.client();
  client.call("session.import", {{"path", kBundle}, {"name", "monday"}});
  InTerminal run(
      {kBin + "/sixdial", "--socket", running.socket_path().string(), "calibrate", "monday",
       "--particles", "2000", "--qpso1-iterations", "100000"},
      60, 24);
  EXPECT_TRUE(run.until_text(".] ")) << run.screen().text();
  run.type("\x03");
  EXPECT_EQ(run.wait(), 130);
  EXPECT_THAT(run.screen().text(), HasSubstr("job 1 goes on in the service"));
  EXPECT_EQ(client.call("job.status", {{"job", 1}})["result"]["state"], "running");
  client.call("job.cancel", {{"job", 1}});
}

TEST(Terminal, ColourIsForTerminalsOnlyAndNotWhereNoColorIsSet) {
  InTerminal coloured({kBin + "/sixdial", "sesion"}, 80, 24);
  EXPECT_EQ(coloured.wait(), 2);
  EXPECT_THAT(coloured.all(), HasSubstr("\x1b[31m"));
  InTerminal plain({kBin + "/sixdial", "sesion"}, 80, 24, "NO_COLOR=1");
  EXPECT_EQ(plain.wait(), 2);
  EXPECT_THAT(plain.all(), Not(HasSubstr("\x1b[3")));
  EXPECT_THAT(plain.all(), HasSubstr("error: 'sixdial' has no command 'sesion'"));
}

TEST(Terminal, ACollectionIsSeenWholeInNarrowAndLowTerminalsAndWhileTheyChange) {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.clock_speed = 10.0;
  mock_devices::MockRig mock(options);
  mock.start();
  service::ServiceOptions service_options;
  service_options.clock_speed = options.clock_speed;
  service_options.clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()));
  testing::RunningService running({}, service_options);
  testing::TempDirectory directory;
  const std::string rig = (directory.path() / "rig.toml").string();
  session::write_file(rig, session::write_rig(mock.connected_rig("modbus-tcp")));
  session::PlanOptions plan_options;
  plan_options.seed = 5;
  const std::string plan = (directory.path() / "plan.csv").string();
  session::write_file(
      plan, session::plan_csv(
                session::plan_random(geometry::default_rig(), 200, plan_options).value(),
                session::layout_of(geometry::default_rig())));
  const std::vector<std::string> words{
      kBin + "/sixdial", "--socket", running.socket_path().string(),
      "collect",         plan,       "--session",
      "monday",          "--rig",    rig};
  {
    InTerminal wide(words, 120, 40);
    const std::array parts{"keys: p pause",
                           "o done . open ! suspect x skipped",
                           "tool x ",
                           "l11 ",
                           "as far off as usual",
                           "] collecting "};
    EXPECT_TRUE(wide.until([&](const std::string& screen) {
      return samples_told(screen) >= 3 && screen.find('@') != std::string::npos &&
             std::ranges::all_of(
                 parts, [&](const char* part) { return count_of(screen, part) == 1; });
    })) << wide.screen().text();
    EXPECT_EQ(wide.screen().wrapped(), 0U);
    // Nothing of an earlier drawing was left behind above it.
    EXPECT_EQ(count_of(wide.screen().everything(), "keys: p pause"), 1U);
    // Made narrower in the middle: once a drawing for the new width is there, all that follows
    // fits.
    wide.resize(60, 24);
    const std::string narrow_keys = wrapped(kKeyHelp, 59).front() + "\n";
    EXPECT_TRUE(wide.until_text(narrow_keys)) << wide.screen().text();
    const std::size_t before = wide.all().size();
    const int told = samples_told(wide.screen().text());
    EXPECT_TRUE(wide.until([&](const std::string& screen) {
      return samples_told(screen) >= told + 3;
    })) << wide.screen().text();
    for (const std::string& line : lines_of(wide.all().substr(before))) {
      EXPECT_LE(line.size(), 60U) << line;
    }
    wide.type("q");
    EXPECT_TRUE(wide.until_text("Stop collecting?")) << wide.screen().text();
    wide.type("n");
    EXPECT_TRUE(wide.until_text("no: it goes on")) << wide.screen().text();
    wide.type("qy");
    EXPECT_EQ(wide.wait(), 6);
  }
  for (const auto& [columns, rows] : {std::pair{60, 24}, {60, 14}, {40, 30}}) {
    InTerminal narrow(
        words, static_cast<std::uint16_t>(columns), static_cast<std::uint16_t>(rows));
    EXPECT_TRUE(narrow.until([&rows = rows](const std::string& screen) {
      return count_of(screen, "collecting ") == 1 && count_of(screen, "keys: p pause") == 1 &&
             (samples_told(screen) > 0 || rows < 20);
    })) << narrow.screen().text();
    narrow.type("\x03");
    EXPECT_EQ(narrow.wait(), 130);
    EXPECT_EQ(narrow.screen().wrapped(), 0U) << narrow.screen().text();
    EXPECT_LE(count_of(narrow.screen().text(), "keys: p"), 1U) << narrow.screen().text();
    EXPECT_THAT(narrow.screen().everything(), HasSubstr("what is stored stays"));
  }
}

TEST(Screen, ShowsSixDialsMapResidualAndKeysInAnySize) {
  std::ostringstream out, err;
  const cli::Console console{.out = out, .err = err, .terminal = true};
  cli::Screen screen(console);
  Json points = Json::array();
  for (int i = 0; i < 30; ++i) {
    points.push_back(
        {{"set", "G1"},
         {"point", i},
         {"repeat", 0},
         {"target_mm", {15.0 + i, 30.0 + 7.0 * (i % 5)}},
         {"state", i < 10 ? "done" : "open"}});
  }
  screen.show_plan(points);
  const auto dial = [](const Json& value_mm, const char* state) {
    return Json{{"value_mm", value_mm}, {"quality", "good"}, {"reason", ""}, {"state", state}};
  };
  screen.show_dials(
      {{"dials",
        {{"A", dial(10.49, "ok")},
         {"B", dial(-12.345, "settling")},
         {"C", dial(nullptr, "lost")},
         {"D", dial(7.125, "ok")},
         {"E", dial(nullptr, "stale")},
         {"F", dial(nullptr, "free")}}},
       {"settle", {{"spread_mm", 0.002}, {"limit_mm", 0.012}, {"settled", true}}},
       {"pose", nullptr}});
  for (const std::size_t width : {30U, 59U, 79U, 110U, 200U}) {
    for (const std::size_t height : {12U, 24U, 50U}) {
      const auto lines = screen.lines(width, height);
      std::string text;
      for (const std::string& line : lines) {
        EXPECT_LE(line.size(), width);
        text += line + "\n";
      }
      EXPECT_LE(lines.size() + 3, height);
      for (const char* each : {"10.49", "-12.3", "LOST", "STALE", "no contact"}) {
        EXPECT_THAT(text, HasSubstr(each)) << width << " x " << height << "\n" << text;
      }
      if (width > 105 || height == 50) {
        EXPECT_GE(std::ranges::count(text, '|'), 10) << text;
        EXPECT_THAT(text, HasSubstr("x 15 to 44, y 30 to 58 mm"));
      }
    }
  }
}

}  // namespace
}  // namespace sixdial::cli
