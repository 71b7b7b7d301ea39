// A session whose instrument gives positions (a laser tracker, a camera): a rig file with
// neither cuboid nor dials goes through the command line as any other.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "cli/cli.h"
#include "mock_devices/session_generator.h"
#include "tests/support/command_line.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;

using ::testing::HasSubstr;
using ::testing::Not;
using testing::TempDirectory;

constexpr double kNoise_mm = 0.003;
constexpr double kBacklash_rad = 0.0008;

const char* const kRig = R"(name = "tracker"
[robot]
model = "five_bar"
working_mode = "++"
assembly = 1
l11_mm = 60.0
l12_mm = 60.0
l21_mm = 60.0
l22_mm = 60.0
d_mm = 90.0
x0_mm = 0.0
y0_mm = 0.0
alpha_deg = 0.0
theta1_offset_deg = 0.0
theta2_offset_deg = 0.0
[instrument]
kind = "position"
sd_mm = 0.003
)";

/// 100 points of G1 and 50 of G2 of the mock rig's true robot, with backlash of joint 2, as a
/// tracker would have seen its tool.
void write_tracker_session(const std::filesystem::path& folder) {
  mock_devices::World world;
  world.robot.parameters = geometry::table_2_robot();
  world.effects = {{"joint_backlash", "joint2", {{"b_rad", kBacklash_rad}}}};
  const auto plan = mock_devices::random_plan(world.rig, 11);
  const mock_devices::GeneratedSession measured = mock_devices::generate_session(world, plan);
  const mock_devices::WorldModel model(world);
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise_mm(0.0, kNoise_mm);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "rig.toml") << kRig;
  std::ofstream csv(folder / "session.csv");
  csv << "set,point,repeat,theta1_rad,theta2_rad,target_x_mm,target_y_mm,approach1,approach2,"
         "x_mm,y_mm\n";
  for (const mock_devices::MeasuredRow& row : measured.rows) {
    mock_devices::Moment moment;
    moment.q_rad = row.planned.q_rad;
    moment.approach = row.approach;
    moment.assembly = row.planned.assembly;
    const auto p_mm = model.tool(moment);
    ASSERT_TRUE(p_mm);
    csv << fmt::format(
        "{},{},{},{:.9f},{:.9f},{:.6f},{:.6f},{},{},{:.6f},{:.6f}\n", row.planned.set,
        row.planned.point, row.planned.repeat, row.planned.q_rad[0], row.planned.q_rad[1],
        row.planned.target_mm->x(), row.planned.target_mm->y(), row.approach[0],
        row.approach[1], p_mm->x() + noise_mm(engine), p_mm->y() + noise_mm(engine));
  }
}

class PositionsOnly : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = (directory_.path() / "tracker").string();
    write_tracker_session(folder_);
  }

  static std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  TempDirectory directory_;
  std::string folder_;
};

TEST_F(PositionsOnly, AreCalibratedAndComparedFromABundle) {
  const Outcome calibrated = sixdial(
      {"calibrate", folder_, "-q", "--qpso1-iterations", "10", "--qpso2-iterations", "60",
       "--anfis-epochs", "10"});
  EXPECT_EQ(calibrated.code, 0) << calibrated.err;
  EXPECT_THAT(calibrated.out, HasSubstr("determine 10 of 10 free parameters"));
  // Of dials, not of the program "sixdial".
  EXPECT_THAT(calibrated.out, Not(::testing::ContainsRegex("(^|[^x])dial")));
  const Outcome compared =
      sixdial({"compare", folder_, "-q", "--json", "--methods", "before,lm,lm+gp"});
  EXPECT_EQ(compared.code, 0) << compared.err;
  const Json document = Json::parse(compared.out);
  ASSERT_EQ(document["methods"].size(), 3U);
  EXPECT_LT(document["methods"][1]["g2"]["mean_mm"], 0.05);
  const Outcome by_dials = sixdial({"compare", folder_, "-q", "--space", "dials"});
  EXPECT_EQ(by_dials.code, 5);
  EXPECT_THAT(by_dials.err, HasSubstr("has no dial readings"));
}

TEST_F(PositionsOnly, AreDiagnosedAndTheNoiseIsTheirs) {
  const Outcome found = sixdial({"diagnose", folder_, "-q", "--bootstrap", "0"});
  EXPECT_EQ(found.code, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("Backlash of joint 2"));
  EXPECT_THAT(found.out, HasSubstr("the positions' noise"));
  EXPECT_THAT(found.out, Not(HasSubstr("the dials' noise")));
}

TEST_F(PositionsOnly, AreReportedWithoutAWordOnDialsThatAreNotThere) {
  const auto report = directory_.path() / "report";
  const Outcome reported =
      sixdial({"report", folder_, "-q", "--method", "lm", "--diagnose", "-o", report.string()});
  EXPECT_EQ(reported.code, 0) << reported.err;
  const std::string page = text_of(report / "report.html");
  EXPECT_THAT(page, HasSubstr("The rig"));
  EXPECT_THAT(page, HasSubstr("O1, motor 1"));
  for (const char* words :
       {"0 dials", "Dials on the table", "from the dials alone", "the dials' noise",
        "the dials&#39; noise", "residual by dial", "left by dial", "cuboid, 80 mm"}) {
    EXPECT_THAT(page, Not(HasSubstr(words))) << words;
  }
}

TEST_F(PositionsOnly, GoThroughTheStoreAndAreNotCollectedHere) {
  testing::RunningService running;
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"--socket", running.socket_path().string()});
    return sixdial(std::move(words));
  };
  EXPECT_EQ(with({"session", "import", folder_, "--name", "monday"}).code, 0);
  const Outcome calibrated = with({"calibrate", "monday", "-q", "--method", "lm"});
  EXPECT_EQ(calibrated.code, 0) << calibrated.err;
  const Outcome diagnosed = with({"diagnose", "monday", "-q", "--bootstrap", "0", "--no-gain"});
  EXPECT_EQ(diagnosed.code, 0) << diagnosed.err;
  const Outcome compared = with({"compare", "monday", "-q", "--methods", "before,lm"});
  EXPECT_EQ(compared.code, 0) << compared.err;
  const auto report = directory_.path() / "stored";
  const Outcome reported = with({"report", "monday", "-o", report.string()});
  EXPECT_EQ(reported.code, 0) << reported.err;
  EXPECT_THAT(text_of(report / "report.html"), HasSubstr("Backlash of joint 2"));
  const Outcome validated = with({"validate", "monday", "--name", "tuesday"});
  EXPECT_EQ(validated.code, 5);
  EXPECT_THAT(validated.err, HasSubstr("reads no position of the tool"));
}

}  // namespace
}  // namespace sixdial::cli
