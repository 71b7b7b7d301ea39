// The mock rig under every controller that it serves: two points collected through it by the
// commands a person types, over real sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "mock_devices/iso_time.h"
#include "mock_devices/mock_arm.h"
#include "mock_devices/mock_rig.h"
#include "session/bundle.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial {
namespace {

constexpr double kSpeed = 40.0;      // rig seconds a wall second
constexpr double kJoint_rad = 2e-6;  // the last digit of a command is 1e-5 deg
// Of two readings at one pose: hysteresis, noise and quantum.
constexpr double kSameReading_mm = 0.02;

/// Collects a plan under a mock that is there, and reads the session back.
session::Session collected(
    const session::Plan& plan, const std::string& rig_text, std::int64_t utc_ms) {
  service::ServiceOptions options;
  options.clock_speed = kSpeed;
  options.clock_start = session::from_iso8601(mock_devices::iso8601(utc_ms));
  const testing::RunningService running({}, options);
  const auto path = [&](const char* name) { return (running.directory() / name).string(); };
  const geometry::Rig rig = session::parse_rig(rig_text, "rig.toml");
  std::ofstream(path("rig.toml")) << rig_text;
  std::ofstream(path("plan.csv")) << session::plan_csv(plan, rig);
  const auto sixdial = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "sixdial");
    words.insert(words.end(), {"--socket", running.socket_path().string()});
    std::vector<const char*> arguments;
    for (const std::string& word : words) arguments.push_back(word.c_str());
    std::ostringstream out;
    std::ostringstream err;
    const int code = cli::run(static_cast<int>(arguments.size()), arguments.data(), out, err);
    EXPECT_EQ(code, 0) << out.str() << err.str();
  };
  sixdial({"collect", path("plan.csv"), "--session", "two", "--rig", path("rig.toml"), "-q"});
  sixdial({"session", "export", "two", path("bundle"), "-q"});
  return session::read_bundle(path("bundle"));
}

/// The five-bar under this controller; empty: the one with registers.
session::Session of_five_bar(const std::string& controller, const session::Plan& plan) {
  mock_devices::MockRigOptions options;
  options.clock_speed = kSpeed;
  options.world.seed = 5;
  options.robot_controller = controller;
  mock_devices::MockRig mock(options);
  mock.start();
  const session::Session session =
      collected(plan, session::write_rig(mock.connected_rig("modbus-tcp")), mock.utc_ms());
  // Whatever moved it, the rig stands where it was sent at last.
  EXPECT_LT((mock.robot().q_rad - plan.points.back().q).norm(), 2 * kJoint_rad);
  return session;
}

session::Plan two_points() {
  session::PlanOptions options;
  options.seed = 3;
  return session::plan_random(geometry::default_rig(), 2, options).value();
}

class ServedControllers : public ::testing::TestWithParam<const char*> {};

TEST_P(ServedControllers, CollectWhatTheOneWithRegistersDoes) {
  const session::Plan plan = two_points();
  static const session::Session by_registers = of_five_bar("", plan);
  const session::Session session = of_five_bar(GetParam(), plan);
  ASSERT_EQ(session.samples.size(), 2U);
  ASSERT_EQ(by_registers.samples.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const session::Sample& sample = session.samples[i];
    EXPECT_LT((sample.q - plan.points[i].q).cwiseAbs().maxCoeff(), kJoint_rad);
    int compared = 0;
    for (std::size_t dial = 0; dial < sample.channels.size(); ++dial) {
      const auto& here = sample.channels[dial].value;
      const auto& there = by_registers.samples[i].channels[dial].value;
      ASSERT_EQ(here.has_value(), there.has_value());
      if (!here) continue;
      EXPECT_LT(std::abs(*here - *there), kSameReading_mm) << "dial " << dial;
      ++compared;
    }
    EXPECT_GE(compared, 3);
    // Both sides of arrival come out of the moves, whoever made them.
    EXPECT_EQ(sample.approach, by_registers.samples[i].approach);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , ServedControllers,
    ::testing::Values("grbl", "marlin", "klipper", "klipper-socket", "linuxcnc"),
    [](const auto& each) {
      std::string name = each.param;
      std::ranges::replace(name, '-', '_');
      return name;
    });

TEST(ServedControllersOfArms, AnArmIsLedByLinuxCnc) {
  mock_devices::MockArmOptions options{
      .world = mock_devices::drawn_arm(2021, 5), .rows = 2, .clock_speed = kSpeed};
  options.robot_controller = "linuxcnc";
  mock_devices::MockArm mock(options);
  mock.start();
  const geometry::Rig rig = session::parse_rig(mock.rig_text(), "rig.toml");
  EXPECT_TRUE(rig.robot.connection.starts_with("linuxcnc:127.0.0.1:"));
  const session::Plan plan = session::plan_random(rig, 2, {.seed = 4}).value();
  const session::Session session = collected(plan, mock.rig_text(), mock.utc_ms());
  ASSERT_EQ(session.samples.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT((session.samples[i].q - plan.points[i].q).cwiseAbs().maxCoeff(), kJoint_rad);
  }
}

}  // namespace
}  // namespace sixdial
