// The command line as a person and a script meet it: exit codes, streams, JSON with a schema.
#include "cli/cli.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "cli/console.h"
#include "session/rig_file.h"
#include "tests/support/command_line.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;

using ::testing::HasSubstr;
using testing::RunningService;
using testing::TempDirectory;

const std::string kBundle = test_paths::test_data() + "/session_00";

TEST(CommandLine, WrongUseIsTwoAndHelpIsZero) {
  EXPECT_EQ(sixdial({}).code, 2);
  EXPECT_EQ(sixdial({"nonsense"}).code, 2);
  EXPECT_EQ(sixdial({"calibrate", "x", "--profile", "best"}).code, 2);
  EXPECT_EQ(sixdial({"session", "show"}).code, 2);
  const Outcome help = sixdial({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* verb :
       {"session", "plan", "collect", "calibrate", "report", "job", "hello"}) {
    EXPECT_THAT(help.out, HasSubstr(verb));
  }
  EXPECT_EQ(sixdial({"--version"}).code, 0);
}

TEST(CommandLine, WithoutAServiceItIsThree) {
  TempDirectory directory;
  const Outcome outcome =
      sixdial({"--socket", (directory.path() / "none").string(), "session", "list"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_TRUE(outcome.out.empty());
  EXPECT_THAT(outcome.err, HasSubstr("no service answers"));
}

TEST(CommandLine, ABundleIsDiagnosedWithoutAService) {
  TempDirectory directory;
  const std::string bundle = test_paths::test_data() + "/sessions/01";
  const std::string page = (directory.path() / "page.html").string();
  const std::string result = (directory.path() / "diagnosis.json").string();
  const Outcome shown = sixdial(
      {"diagnose", bundle, "-q", "--bootstrap", "0", "--no-gain", "--report", page, "-o",
       result});
  EXPECT_EQ(shown.code, 0) << shown.err;
  for (const char* words : {"Backlash of joint 2", "0.0208", "What to do", "detected from"}) {
    EXPECT_THAT(shown.out, HasSubstr(words));
  }
  EXPECT_GT(std::filesystem::file_size(page), 10'000U);

  const Outcome json =
      sixdial({"--json", "diagnose", bundle, "-q", "--bootstrap", "0", "--no-gain"});
  EXPECT_EQ(json.code, 0);
  EXPECT_EQ(json.json()["causes"][0]["cause"], "joint_backlash");
  EXPECT_EQ(json.json()["schema"], "sixdial.diagnosis");
  EXPECT_EQ(json.json()["schema_version"], 1);

  // Commanding by what was found; arriving from above stops lower by the backlash.
  const auto angle = [&](const char* approach) {
    const Outcome answer = sixdial(
        {"--json", "compensate", bundle, "-q", "--model", "extended", "--diagnosis-file",
         result, "--target", "28,48", "--approach", approach});
    EXPECT_EQ(answer.code, 0) << answer.err;
    return answer.json()["theta_rad"][1].get<double>();
  };
  const double backlash_rad = json.json()["causes"][0]["estimate"][0]["value"];
  EXPECT_LT(std::abs(angle("1,1") - angle("1,-1") - backlash_rad), 1e-8);

  EXPECT_EQ(sixdial({"diagnose", "/no/such/bundle"}).code, 5);
  EXPECT_EQ(sixdial({"diagnose", bundle, "--bootstrap", "-3"}).code, 2);
}

TEST(CommandLine, ABundleIsCalibratedAndReportedWithoutAService) {
  TempDirectory directory;
  const std::string result = (directory.path() / "result.json").string();
  const Outcome calibrated = sixdial(
      {"calibrate", kBundle, "-q", "--qpso1-iterations", "10", "--qpso2-iterations", "40",
       "--anfis-epochs", "10", "-o", result});
  EXPECT_EQ(calibrated.code, 0) << calibrated.err;
  EXPECT_THAT(calibrated.out, HasSubstr("before calibration"));
  EXPECT_THAT(calibrated.out, HasSubstr("EKF-DQPSO + ANFIS"));
  EXPECT_EQ(calibrated.out.find('\x1b'), std::string::npos);  // no colour off a terminal
  const auto folder = directory.path() / "report";
  const Outcome reported =
      sixdial({"report", kBundle, "--calibration", result, "-o", folder.string()});
  EXPECT_EQ(reported.code, 0) << reported.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "report.html"));
}

TEST(CommandLine, ABundlesTargetIsCompensatedWithoutAService) {
  const std::vector<std::string> ask{"compensate", kBundle, "-q",       "--json",
                                     "--method",   "full",  "--target", "28,48"};
  const Outcome outcome = sixdial(ask);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_LT(outcome.json()["closure_mm"], 1e-9);
  EXPECT_EQ(sixdial({"compensate", kBundle}).code, 2);  // neither a target nor a plan
  const Outcome far = sixdial({"compensate", kBundle, "-q", "--target", "-500,48"});
  EXPECT_EQ(far.code, 5);
  EXPECT_THAT(far.err, HasSubstr("-500.000"));
}

TEST(CommandLine, NominalJointValuesAreNotGivenOutAsCompensated) {
  const std::vector<std::string> ask{"compensate", kBundle,    "-q",   "--calibration-method",
                                     "lm",         "--target", "28,48"};
  std::vector<std::string> nominal = ask;
  nominal.insert(nominal.end(), {"--model", "before"});
  const Outcome by_nominal = sixdial(nominal);
  EXPECT_EQ(by_nominal.code, 0) << by_nominal.err;
  EXPECT_THAT(by_nominal.err, HasSubstr("nothing is compensated"));
  EXPECT_EQ(sixdial(ask).err, "");
}

TEST(CommandLine, OffATerminalCompensationSaysOneLineOfTheCalibrationItMakesFirst) {
  TempDirectory directory;
  const std::string plan = (directory.path() / "plan.csv").string();
  ASSERT_EQ(
      sixdial({"plan", "random", "--rig", kBundle + "/rig.toml", "--count", "2", "-o", plan})
          .code,
      0);
  const Outcome outcome = sixdial({"compensate", kBundle, "--plan", plan});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("making the calibration first; --calibration FILE"));
  EXPECT_EQ(std::ranges::count(outcome.out, '\n'), 3) << outcome.out;  // titles, two points
  const Outcome quiet = sixdial({"compensate", kBundle, "-q", "--plan", plan});
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(quiet.out, outcome.out);
}

TEST(CommandLine, AWrongBundleIsFiveWithFileLineAndColumn) {
  TempDirectory directory;
  std::filesystem::copy_file(kBundle + "/rig.toml", directory.path() / "rig.toml");
  std::ofstream(directory.path() / "session.csv")
      << "set,theta1_rad,theta2_rad,x_mm,y_mm\nG1,1.4,oops,20,50\n";
  const Outcome outcome = sixdial({"calibrate", directory.path().string()});
  EXPECT_EQ(outcome.code, 5);
  EXPECT_THAT(outcome.err, HasSubstr("session.csv:2:8"));
}

TEST(CommandLine, JsonHasASchemaAndItsVersionEverywhere) {
  RunningService running;
  const std::string socket = running.socket_path().string();
  const auto ask = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--json", "-q", "--socket", socket});
    const Outcome outcome = sixdial(std::move(words));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const Json json = outcome.json();
    EXPECT_TRUE(json["schema"].get<std::string>().starts_with("sixdial."));
    EXPECT_EQ(json["schema_version"], 1);
    return json;
  };
  TempDirectory directory;
  const std::string rig = (directory.path() / "rig.toml").string();
  std::ofstream(rig) << session::write_rig(geometry::default_rig());
  EXPECT_EQ(ask({"hello"})["service"], "sixdiald");
  EXPECT_GT(ask({"protocol"})["methods"].size(), 20U);
  EXPECT_EQ(ask({"session", "import", kBundle, "--name", "one"})["samples"], 150);
  EXPECT_EQ(ask({"session", "create", "two", "--rig", rig})["samples"], 0);
  EXPECT_EQ(ask({"session", "list"})["sessions"].size(), 2U);
  EXPECT_EQ(ask({"session", "show", "one", "--limit", "3"})["page"].size(), 3U);
  EXPECT_EQ(ask({"plan", "grid", "--rig", rig})["points"], 100);
  EXPECT_EQ(ask({"plan", "grid", "--rig", rig, "--mode=++,-+"})["notes"].size(), 2U);
  EXPECT_EQ(ask({"plan", "next", "one", "--points", "4"})["points"], 4);
  const Json next = ask({"plan", "next", kBundle, "--points", "3", "--criterion", "D"});
  EXPECT_EQ(next["steps"].size(), 3U);
  EXPECT_LT(next["after"]["max_mm"], next["now"]["max_mm"]);
  const Json calibrated = ask(
      {"calibrate", "one", "--qpso1-iterations", "10", "--qpso2-iterations", "40",
       "--anfis-epochs", "10"});
  EXPECT_EQ(calibrated["methods"][0]["id"], "before");
  EXPECT_EQ(ask({"job", "list"})["jobs"][0]["state"], "done");
  EXPECT_EQ(ask({"job", "wait", "1"})["state"], "done");
  EXPECT_EQ(ask({"job", "status", "1"})["job"], 1);
  EXPECT_EQ(ask({"report", "one", "-o", (directory.path() / "r").string()})["result"], 1);
  EXPECT_EQ(
      ask({"session", "export", "one", (directory.path() / "e").string()})["samples"], 150);
  EXPECT_EQ(ask({"collection", "status"})["state"], "idle");
}

TEST(CommandLine, AWorkingModeThatThereIsNotIsWrongUse) {
  EXPECT_EQ(sixdial({"plan", "grid", "--rig", "rig.toml", "--mode=++,+"}).code, 2);
  EXPECT_EQ(sixdial({"plan", "next", kBundle, "--criterion", "E"}).code, 2);
  EXPECT_EQ(sixdial({"collect", "--session", "a", "--stop-below", "-1"}).code, 2);
}

TEST(CommandLine, ErrorsOfTheServiceHaveTheirExitCodes) {
  RunningService running;
  const std::string socket = running.socket_path().string();
  EXPECT_EQ(sixdial({"--socket", socket, "session", "show", "nobody"}).code, 1);
  EXPECT_EQ(sixdial({"--socket", socket, "job", "status", "77"}).code, 1);
  const Outcome outcome = sixdial({"--socket", socket, "--json", "session", "show", "nobody"});
  EXPECT_EQ(outcome.json()["error"]["data"]["code"], "not_found");
  TempDirectory directory;
  std::ofstream(directory.path() / "rig.toml") << "side_mm = 3\n";
  EXPECT_EQ(
      sixdial({"--socket", socket, "session", "create", "x", "--rig",
               (directory.path() / "rig.toml").string()})
          .code,
      5);
}

TEST(CommandLine, ACancelledJobIsSix) {
  RunningService running;
  const std::string socket = running.socket_path().string();
  ASSERT_EQ(
      sixdial({"--socket", socket, "session", "import", kBundle, "--name", "one"}).code, 0);
  std::thread canceller([&] {
    EXPECT_TRUE(testing::eventually([&] {
      for (const service::Job& job : running.service().jobs().list()) {
        if (job.state == service::JobState::kRunning)
          return running.service().jobs().cancel(job.id);
      }
      return false;
    }));
  });
  const Outcome outcome = sixdial(
      {"--socket", socket, "-q", "calibrate", "one", "--particles", "2000",
       "--qpso1-iterations", "100000"});
  canceller.join();
  EXPECT_EQ(outcome.code, 6) << outcome.err;
}

TEST(Console, APlainLineIsPrintedAtEachStageAndTenth) {
  std::ostringstream out;
  std::ostringstream err;
  cli::Console console{.out = out, .err = err};
  {
    cli::ProgressLine line(console);
    for (int i = 0; i <= 100; ++i) line.show("measuring", i, 100, 65.0, "");
  }
  const std::string text = err.str();
  EXPECT_EQ(std::ranges::count(text, '\n'), 11);
  EXPECT_THAT(text, HasSubstr("measuring 50/100  1:05 left"));
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_TRUE(out.str().empty());
}

TEST(Console, TablesLineUp) {
  const std::string text = cli::text_table({"name", "points"}, {{"a", "5"}, {"longer", "150"}});
  EXPECT_EQ(text, "name    points\na            5\nlonger     150\n");
}

}  // namespace
}  // namespace sixdial::cli
