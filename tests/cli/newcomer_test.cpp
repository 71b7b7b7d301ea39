// Mistakes of somebody new at the command line: each is answered by what was meant and by the
// next command to type, with the right exit code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "session/rig_file.h"
#include "tests/support/command_line.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;

using ::testing::HasSubstr;
using ::testing::Not;
using testing::RunningService;
using testing::TempDirectory;

const std::string kBundle = test_paths::test_data() + "/session_00";

struct Mistake {
  std::vector<std::string> words;
  int code;
  std::vector<std::string> answers;  // each is in what is said
};

void expect_answered(const Mistake& mistake, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words = mistake.words;
  words.insert(words.end(), more.begin(), more.end());
  std::string typed;
  for (const std::string& each : mistake.words) typed += each + " ";
  const Outcome outcome = sixdial(words);
  EXPECT_EQ(outcome.code, mistake.code) << typed << outcome.err;
  EXPECT_TRUE(outcome.out.empty()) << typed << outcome.out;
  for (const std::string& answer : mistake.answers) {
    EXPECT_THAT(outcome.err, HasSubstr(answer)) << typed;
  }
}

TEST(Newcomer, WhatWasTypedWrongIsNamedWithTheNearestWord) {
  const std::vector<Mistake> mistakes{
      {{}, 2, {"'sixdial' needs a command", "Commands: session, plan, collect"}},
      {{"sesion", "list"}, 2, {"no command 'sesion'; did you mean 'session'?"}},
      {{"calibrat", "monday"}, 2, {"did you mean 'calibrate'?"}},
      {{"measure"}, 2, {"did you mean 'collect'?"}},
      {{"status"}, 2, {"did you mean 'collection'?"}},
      {{"xyzzy"}, 2, {"no command 'xyzzy'", "Commands: session"}},
      {{"session"}, 2, {"'sixdial session' needs a command", "create, list, show"}},
      {{"session", "shwo", "x"}, 2, {"'sixdial session' has no command 'shwo'", "'show'"}},
      {{"calibrate", "x", "--sead", "1"}, 2, {"no option --sead", "'--seed'"}},
      {{"calibrate"}, 2, {"SESSION|BUNDLE is required", "sixdial calibrate monday"}},
      {{"calibrate", "a", "b"}, 2, {"'b' is one word too many", "sixdial calibrate --help"}},
      {{"calibrate", "x", "--profile", "best"}, 2, {"--profile", "default"}},
      {{"collect"}, 2, {"--session is required", "collect plan.csv --session monday"}},
      {{"collect", "plan.csv", "--session", "x"},
       2,
       {"no such file: plan.csv", "sixdial plan random --rig rig.toml --count 100"}},
      {{"plan", "random"}, 2, {"--rig is required", "sixdial plan random --rig rig.toml"}},
      {{"job", "status", "abc"}, 2, {"JOB", "sixdial job status 1"}}};
  for (const Mistake& mistake : mistakes) expect_answered(mistake);
  EXPECT_THAT(sixdial({"--json", "sesion"}).out, HasSubstr(R"("code":"invalid_params")"));
}

TEST(Newcomer, HelpIsFoundByWordToo) {
  const Outcome whole = sixdial({"help"});
  EXPECT_EQ(whole.code, 0);
  EXPECT_THAT(whole.out, HasSubstr("calibrate"));
  EXPECT_EQ(sixdial({"help", "plan"}).out, sixdial({"plan", "--help"}).out);
}

TEST(Newcomer, WithoutAServiceTheWayToOneIsTold) {
  TempDirectory directory;
  const std::string socket = (directory.path() / "none").string();
  expect_answered(
      {{"session", "list"}, 3, {"no service answers", "sixdiald &", "sixdial doctor"}},
      {"--socket", socket});
  expect_answered(
      {{"calibrate", "/no/such/folder"}, 5, {"there is no such folder", "session.csv"}});
  expect_answered(
      {{"report", kBundle, "--calibration", kBundle + "/rig.toml"},
       5,
       {"rig.toml is no JSON document", "-o of sixdial calibrate"}});
  expect_answered({{"plan", "random", "--rig", "none.toml"}, 5, {"none.toml: cannot be read"}});
  // Advice that the message holds already is not said again.
  const Outcome once = sixdial({"plan", "random", "--rig", "none.toml"});
  const std::string advice = "check the path";
  EXPECT_EQ(once.err.find(advice), once.err.rfind(advice));
}

TEST(Newcomer, TheServicesRefusalsNameCommandsAndFilesNotMethods) {
  RunningService running;
  const std::vector<std::string> socket{"--socket", running.socket_path().string()};
  TempDirectory directory;
  const std::string rig = (directory.path() / "my_rig.toml").string();
  std::ofstream(rig) << session::write_rig(geometry::default_rig());
  const std::string notes = (directory.path() / "notes.txt").string();
  std::ofstream(notes) << "# no rig, no plan\n";
  ASSERT_EQ(
      sixdial({"session", "create", "monday", "--rig", rig, socket[0], socket[1]}).code, 0);
  const std::vector<Mistake> mistakes{
      {{"calibrate", "munday"}, 1, {"'monday'", "sixdial session list"}},
      {{"calibrate", "monday"}, 5, {"at least 3 are needed", "sixdial collect PLAN --session"}},
      {{"report", "monday"}, 1, {"has no result yet", "sixdial calibrate monday"}},
      {{"validate", "monday"}, 1, {"sixdial calibrate monday"}},
      {{"collect", "--session", "monday"},
       5,
       {"has no plan", "sixdial plan random --rig rig.toml", "--session monday"}},
      {{"collection", "pause"}, 1, {"nothing is being collected", "sixdial collect PLAN"}},
      {{"job", "status", "99"}, 1, {"no job number 99", "sixdial job list"}},
      {{"session", "create", "monday", "--rig", rig}, 1, {"there is a session 'monday'"}},
      {{"session", "create", "a b", "--rig", rig}, 2, {"'a b'", "Letters, digits"}},
      {{"session", "create", "x", "--rig", notes}, 5, {notes}},
      {{"collect", notes, "--session", "monday"}, 5, {notes + ":1:1", "needs set, point"}},
      {{"session", "import", "/nowhere"}, 5, {"there is no such folder"}}};
  for (const Mistake& mistake : mistakes) {
    expect_answered(mistake, socket);
    std::vector<std::string> words = mistake.words;
    words.insert(words.end(), socket.begin(), socket.end());
    const Outcome outcome = sixdial(words);
    for (const char* method : {"calibrate.start", "collect.start", "plan.random", "plan_csv"}) {
      EXPECT_THAT(outcome.err, Not(HasSubstr(method)));
    }
  }
}

}  // namespace
}  // namespace sixdial::cli
