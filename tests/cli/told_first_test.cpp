// What speaks against a session stands in the first lines of every command, in `warnings` of
// --json, and in the exit code; and results are not taken for those of other data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "cli/cli.h"
#include "report/documents/json.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using ::testing::HasSubstr;
using testing::TempDirectory;

const std::string kRight = test_paths::test_data() + "/session_00";

struct Said {
  int code = 0;
  std::string out, err;
};

Said sixdial(std::vector<std::string> words) {
  words.insert(words.begin(), "sixdial");
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  std::ostringstream out, err;
  Said said;
  said.code = cli::run(static_cast<int>(arguments.size()), arguments.data(), out, err);
  said.out = out.str();
  said.err = err.str();
  return said;
}

/// The right bundle with one text of one of its files replaced.
std::string bundle_with(
    const TempDirectory& folder, const std::string& file, const std::string& old,
    const std::string& fresh) {
  const std::string path = (folder.path() / "bundle").string();
  session::write_bundle(session::read_bundle(kRight), path);
  std::string text = session::read_file(path + "/" + file);
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  text.replace(at, old.size(), fresh);
  session::write_file(path + "/" + file, text);
  return path;
}

std::string first_lines(const std::string& text) { return text.substr(0, 400); }

TEST(ToldFirst, AWrongModeInEveryCommand) {
  const TempDirectory folder;
  const std::string bundle =
      bundle_with(folder, "rig.toml", "working_mode = \"++\"", "working_mode = \"--\"");
  const Said calibrated = sixdial({"calibrate", bundle, "--method", "lm", "--quiet"});
  EXPECT_EQ(calibrated.code, 5);
  EXPECT_THAT(first_lines(calibrated.out), HasSubstr("Not calibrated"));
  EXPECT_THAT(first_lines(calibrated.out), HasSubstr("working mode ++"));

  const Json document =
      Json::parse(sixdial({"--json", "calibrate", bundle, "--method", "lm", "--quiet"}).out);
  EXPECT_EQ(document["state"], "not_calibrated");
  ASSERT_EQ(document["warnings"].size(), 1U);
  EXPECT_EQ(document["warnings"][0]["code"], "wrong_mode");

  const Said compared = sixdial({"compare", bundle, "--methods", "before,lm", "--quiet"});
  EXPECT_THAT(first_lines(compared.out), HasSubstr("working mode ++"));

  // The samples' branch is commanded, and that is said.
  const Said commanded = sixdial(
      {"--json", "compensate", bundle, "--calibration-method", "lm", "--target", "22,36",
       "--quiet"});
  EXPECT_EQ(commanded.code, 0);
  EXPECT_EQ(Json::parse(commanded.out)["mode"], "++");
  EXPECT_EQ(Json::parse(commanded.out)["warnings"][0]["code"], "wrong_mode");

  const std::string report = (folder.path() / "report").string();
  const Said reported =
      sixdial({"--json", "report", bundle, "--method", "lm", "-o", report, "--quiet"});
  EXPECT_EQ(reported.code, 5);
  EXPECT_EQ(Json::parse(reported.out)["warnings"][0]["code"], "wrong_mode");
  const Json written = Json::parse(session::read_file(report + "/report.json"));
  EXPECT_EQ(written["state"]["state"], "not_calibrated");
  EXPECT_EQ(written["warnings"][0]["code"], "wrong_mode");
}

TEST(ToldFirst, ARightSessionSaysNothingAndEndsWell) {
  const Said calibrated = sixdial({"calibrate", kRight, "--method", "lm", "--quiet"});
  EXPECT_EQ(calibrated.code, 0);
  EXPECT_TRUE(calibrated.out.starts_with("Calibrated")) << first_lines(calibrated.out);
}

TEST(ToldFirst, NothingIsCommandedByARigFileThatContradictsTheReadings) {
  const TempDirectory folder;
  const std::string bundle = bundle_with(
      folder, "rig.toml", "reference_pose_mm = [28.0, 48.0]",
      "reference_pose_mm = [0.0, 60.0]");
  const Said commanded = sixdial(
      {"compensate", bundle, "--calibration-method", "lm", "--target", "22,36", "--quiet"});
  EXPECT_EQ(commanded.code, 5);
  EXPECT_THAT(commanded.err, HasSubstr("reference_pose_mm"));
  EXPECT_EQ(commanded.out, "");
}

TEST(ToldFirst, AResultOfOtherDataIsRefusedUnlessItIsAskedFor) {
  const TempDirectory folder;
  const std::string stored = (folder.path() / "calibration.json").string();
  ASSERT_EQ(sixdial({"calibrate", kRight, "--method", "lm", "--quiet", "-o", stored}).code, 0);
  const std::string other = bundle_with(folder, "session.csv", ",20.03,", ",20.04,");
  const std::vector<std::string> command{"compensate", other,   "--calibration", stored,
                                         "--target",   "22,36", "--quiet"};
  const Said refused = sixdial(command);
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, HasSubstr("--from-other-session"));
  std::vector<std::string> allowed = command;
  allowed.emplace_back("--from-other-session");
  EXPECT_EQ(sixdial(allowed).code, 0);
  const Said report = sixdial(
      {"report", other, "--calibration", stored, "-o", (folder.path() / "r").string(),
       "--quiet"});
  EXPECT_EQ(report.code, 5);
}

TEST(ToldFirst, NothingToIdentifyIsAnErrorInWords) {
  const Said said = sixdial(
      {"calibrate", kRight, "--quiet", "--fix",
       "l11,l12,l21,l22,d,x0,y0,alpha,dtheta1,dtheta2"});
  EXPECT_EQ(said.code, 2);
  EXPECT_THAT(said.err, HasSubstr("nothing to identify"));
}

}  // namespace
}  // namespace sixdial::cli
