// sixdial export-model as people call it: of a bundle and of a session, what it refuses, what
// it tells, and that the exported robot goes where `compensate` sends it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "session/csv.h"
#include "tests/support/command_line.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Outcome;
using testing::RunningService;
using testing::sixdial;
using testing::TempDirectory;

const std::string kBacklash = test_paths::test_data() + "/sessions/01";
const std::string kOther = test_paths::test_data() + "/sessions/00";

class ExportModel : public ::testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  /// What a program prints; it must end well.
  [[nodiscard]] std::string said_by(const std::string& command) const {
    const std::string out = file("said");
    const int status = std::system(
        fmt::format("cd {} && {} > {} 2>&1", folder_.path().string(), command, out).c_str());
    const std::string said = session::read_file(out);
    EXPECT_EQ(status, 0) << said;
    return said;
  }

  TempDirectory folder_;
};

TEST_F(ExportModel, GoesWhereCompensateSendsIt) {
  ASSERT_EQ(
      sixdial({"diagnose", kBacklash, "-q", "--bootstrap", "0", "--no-gain", "-o",
               file("diagnosis.json")})
          .code,
      0);
  for (const char* const format : {"python", "c"}) {
    const Outcome exported = sixdial(
        {"export-model", kBacklash, "--as", format, "--diagnosis-file", file("diagnosis.json"),
         "-o", file(format[0] == 'c' ? "robot.c" : "robot.py")});
    EXPECT_EQ(exported.code, 0) << exported.err;
    EXPECT_THAT(exported.err, HasSubstr("the extended model in"));
    EXPECT_THAT(exported.err, HasSubstr("Nothing of the model is left out"));
  }
  session::write_file(file("main.c"), R"c(
#include "robot.c"
#include <stdio.h>
#include <stdlib.h>
int main(int count, char **words) {
  sixdial_moment at = sixdial_end_of_session;
  const double q[2] = {atof(words[1]), atof(words[2])};
  double p[3];
  (void)count;
  at.approach[0] = 1.0;
  at.approach[1] = atof(words[3]);
  if (sixdial_forward(q, &at, p, NULL) != 0) return 1;
  printf("%.12f %.12f\n", p[0], p[1]);
  return 0;
}
)c");
  static_cast<void>(said_by("cc -std=c99 -Wall -Werror main.c -o run -lm"));
  for (const char* const side : {"1", "-1"}) {
    const Outcome commanded = sixdial(
        {"--json", "compensate", kBacklash, "-q", "--model", "extended", "--diagnosis-file",
         file("diagnosis.json"), "--target", "28,48", "--approach", std::string("1,") + side});
    ASSERT_EQ(commanded.code, 0) << commanded.err;
    const Json theta = commanded.json()["theta_rad"];
    const std::string in_c = said_by(fmt::format(
        "./run {:.17g} {:.17g} {}", theta[0].get<double>(), theta[1].get<double>(), side));
    const std::string in_python = said_by(fmt::format(
        "python3 -c 'import robot; p, R = robot.forward([{:.17g}, {:.17g}], "
        "robot.Moment(approach=(1, {}))); print(\"%.12f %.12f\" % (p[0], p[1]))'",
        theta[0].get<double>(), theta[1].get<double>(), side));
    for (const std::string& said : {in_c, in_python}) {
      double x = 0.0, y = 0.0;
      ASSERT_EQ(std::sscanf(said.c_str(), "%lf %lf", &x, &y), 2) << said;
      EXPECT_NEAR(x, 28.0, 1e-8);
      EXPECT_NEAR(y, 48.0, 1e-8);
    }
  }
}

TEST_F(ExportModel, TellsWhatAFormatLeavesOut) {
  const Outcome exported =
      sixdial({"export-model", kBacklash, "-q", "--as", "c", "--calibration-method", "lm+gp"});
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_THAT(exported.out, HasSubstr("int sixdial_inverse("));
  EXPECT_THAT(exported.out, HasSubstr("Left out: what gp learned of the rest"));
  EXPECT_THAT(exported.err, HasSubstr("Left out: what gp learned of the rest"));
  EXPECT_THAT(exported.err, HasSubstr("over 150 poses of the session"));
  const Outcome json = sixdial(
      {"--json", "export-model", kBacklash, "-q", "--as", "json", "--calibration-method",
       "lm"});
  EXPECT_EQ(json.code, 0) << json.err;
  EXPECT_EQ(json.json()["schema"], "sixdial.export");
  EXPECT_EQ(json.json()["model"], "kinematics");
  EXPECT_EQ(Json::parse(json.json()["text"].get<std::string>())["schema"], "sixdial.robot");
}

TEST_F(ExportModel, RefusesWhatItCannotHoldAndResultsOfOtherData) {
  ASSERT_EQ(
      sixdial({"calibrate", kOther, "-q", "--method", "lm", "-o", file("other.json")}).code, 0);
  const Outcome urdf = sixdial(
      {"export-model", kOther, "--as", "urdf", "--calibration", file("other.json"), "-o",
       file("robot.urdf")});
  EXPECT_EQ(urdf.code, 2);
  EXPECT_THAT(urdf.err, HasSubstr("a URDF cannot hold this robot (planar five-bar)"));
  EXPECT_THAT(urdf.err, HasSubstr("c, python and json"));
  EXPECT_FALSE(std::filesystem::exists(file("robot.urdf")));
  const std::vector<std::string> wrong{"export-model", kBacklash,       "--as",
                                       "python",       "--calibration", file("other.json")};
  const Outcome other = sixdial(wrong);
  EXPECT_EQ(other.code, 5);
  EXPECT_THAT(other.err, HasSubstr("not from those of"));
  std::vector<std::string> allowed = wrong;
  allowed.emplace_back("--from-other-session");
  EXPECT_EQ(sixdial(allowed).code, 0);
  EXPECT_EQ(sixdial({"export-model", kOther}).code, 2);
  EXPECT_EQ(sixdial({"export-model", kOther, "--as", "step"}).code, 2);
}

TEST_F(ExportModel, OfASessionIsThatOfItsBundle) {
  RunningService running;
  const std::string socket = running.socket_path().string();
  const auto ask = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"--socket", socket});
    return sixdial(std::move(words));
  };
  ASSERT_EQ(ask({"session", "import", kBacklash, "--name", "monday"}).code, 0);
  EXPECT_EQ(ask({"export-model", "monday", "--as", "python"}).code, 1);  // no calibration yet
  ASSERT_EQ(ask({"calibrate", "monday", "-q", "--method", "lm+gp"}).code, 0);
  const Outcome whole = ask({"export-model", "monday", "--as", "json", "-o", file("a.json")});
  EXPECT_EQ(whole.code, 0) << whole.err;
  const std::string text = session::read_file(file("a.json"));
  EXPECT_EQ(Json::parse(text)["learned"]["name"], "gp");
  const Outcome bundle = sixdial(
      {"export-model", kBacklash, "-q", "--as", "json", "--calibration-method", "lm+gp", "-o",
       file("b.json")});
  EXPECT_EQ(bundle.code, 0) << bundle.err;
  EXPECT_EQ(
      Json::parse(text)["robot"]["parameters"],
      Json::parse(session::read_file(file("b.json")))["robot"]["parameters"]);
  ASSERT_EQ(ask({"diagnose", "monday", "-q", "--bootstrap", "0", "--no-gain"}).code, 0);
  const Outcome extended = ask({"export-model", "monday", "--as", "c", "--model", "extended"});
  EXPECT_EQ(extended.code, 0) << extended.err;
  EXPECT_THAT(extended.out, HasSubstr("/* backlash of joint 2 */"));
  EXPECT_THAT(ask({"export-model", "monday", "--as", "c"}).out, Not(HasSubstr("backlash")));
}

}  // namespace
}  // namespace sixdial::cli
