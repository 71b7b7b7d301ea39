// An arm from the plan to the report, by the commands a person types: mock arm under draw
// wires, service, command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "mock_devices/iso_time.h"
#include "mock_devices/mock_arm.h"
#include "session/csv.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial {
namespace {

using ::testing::HasSubstr;

constexpr double kSpeed = 60.0;         // rig seconds a wall second
constexpr double kBacklash_rad = 6e-4;  // 0.034 deg
constexpr double kNoise_mm = 0.02;

struct Outcome {
  int code = -1;
  std::string out, err;
};

class ArmSession : public ::testing::Test {
 protected:
  Outcome sixdial(std::vector<std::string> words) {
    words.insert(words.begin(), "sixdial");
    words.insert(words.end(), {"--socket", running_->socket_path().string()});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    std::ostringstream out;
    std::ostringstream err;
    Outcome outcome;
    outcome.code = cli::run(static_cast<int>(arguments.size()), arguments.data(), out, err);
    outcome.out = out.str();
    outcome.err = err.str();
    return outcome;
  }
  [[nodiscard]] std::string path(const char* name) const {
    return (running_->directory() / name).string();
  }
  void start() {
    mock_devices::ArmWorld world = mock_devices::drawn_arm(2021, 5);
    world.noise_mm = kNoise_mm;
    world.effects = {
        mock_devices::make_arm_effect(world, "joint_backlash", "joint2", kBacklash_rad)};
    mock_ = std::make_unique<mock_devices::MockArm>(
        mock_devices::MockArmOptions{.world = world, .rows = 130, .clock_speed = kSpeed});
    mock_->start();
    service::ServiceOptions options;
    options.clock_speed = kSpeed;
    options.clock_start = session::from_iso8601(mock_devices::iso8601(mock_->utc_ms()));
    running_.emplace(service::ServerOptions{}, options);
    std::ofstream(path("rig.toml")) << mock_->rig_text();
  }
  std::unique_ptr<mock_devices::MockArm> mock_;
  std::optional<testing::RunningService> running_;
};

TEST_F(ArmSession, IsCollectedCalibratedDiagnosedAndReported) {
  start();
  for (const auto& [set, count, seed] :
       {std::tuple{"G1", "90", "1"}, std::tuple{"G2", "40", "2"}}) {
    const Outcome planned = sixdial(
        {"plan", "random", "--rig", path("rig.toml"), "--set", set, "--count", count, "--seed",
         seed, "-o", path(set)});
    ASSERT_EQ(planned.code, 0) << planned.err;
  }
  const std::string g2 = session::read_file(path("G2"));
  std::ofstream(path("plan.csv"))
      << session::read_file(path("G1")) << g2.substr(g2.find('\n') + 1);

  const Outcome collected =
      sixdial({"collect", path("plan.csv"), "--session", "arm", "--rig", path("rig.toml")});
  ASSERT_EQ(collected.code, 0) << collected.err << collected.out;
  EXPECT_THAT(collected.out, HasSubstr("130 of 130 points, 130 stored now"));

  // What the store gives back is the instrument, and so is the bundle.
  const Outcome exported = sixdial({"session", "export", "arm", path("bundle")});
  ASSERT_EQ(exported.code, 0) << exported.err;
  const std::string csv = session::read_file(path("bundle") + "/session.csv");
  EXPECT_THAT(csv.substr(0, csv.find('\n')), HasSubstr("q5_rad"));
  EXPECT_THAT(csv.substr(0, csv.find('\n')), HasSubstr("x_mm,y_mm,z_mm"));

  const Outcome calibrated = sixdial({"calibrate", "arm", "--method", "lm", "--json", "-q"});
  ASSERT_EQ(calibrated.code, 0) << calibrated.err;

  const Outcome diagnosed = sixdial({"diagnose", "arm", "--json", "-q"});
  ASSERT_EQ(diagnosed.code, 0) << diagnosed.err;
  const Json diagnosis = Json::parse(diagnosed.out);
  bool found = false;
  for (const Json& each : diagnosis["causes"]) {
    found = found || (each["cause"] == "joint_backlash" && each["where"] == "joint2");
  }
  EXPECT_TRUE(found) << diagnosis["causes"];

  const Outcome reported = sixdial({"report", "arm", "-o", path("report")});
  ASSERT_EQ(reported.code, 0) << reported.err;
  EXPECT_TRUE(std::filesystem::exists(path("report")));
}

}  // namespace
}  // namespace sixdial
