// Joint values that were commanded and read back: which of them are right, and what is said
// where they scatter.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "mock_devices/arm_world.h"
#include "report/words/warning_words.h"
#include "session/bundle.h"
#include "studies/diagnose.h"
#include "tests/studies/plausible_session.h"

namespace sixdial::studies {
namespace {

using mock_devices::ArmWorld;

/// Written as files and read back.
session::Session session_of(const ArmWorld& world, int rows = 120) {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("sixdial_joint_values_" + std::to_string(::getpid()));
  write_arm_bundle(folder, measure_arm(world, 2 * rows / 3, rows / 3), world);
  session::Session session = session::read_bundle(folder.string());
  std::filesystem::remove_all(folder);
  return session;
}

ArmWorld arm_with(double stop_rad, double read_rad, std::uint64_t seed) {
  ArmWorld world = mock_devices::drawn_arm(seed);
  world.noise_mm = 0.02;
  world.stop_scatter_rad = stop_rad;
  world.read_scatter_rad = read_rad;
  world.writes_commands = true;
  return world;
}

bool told(const PlausibleSession& judged, const std::string& code) {
  return std::ranges::find(judged.warnings, code, &Warning::code) != judged.warnings.end();
}

constexpr std::uint64_t kFirstSeed = 5200;
constexpr std::uint64_t kSessions = 8;

TEST(JointValues, AnEncoderThatScattersLosesAgainstTheCommand) {
  for (std::uint64_t i = 0; i < kSessions; ++i) {
    const session::Session session = session_of(arm_with(0.0, 2e-4, kFirstSeed + i));
    const PlausibleSession judged = plausible(session);
    EXPECT_TRUE(told(judged, "commanded_joints_fit_better")) << kFirstSeed + i;
    EXPECT_TRUE(is_clean(judged.warnings));
    for (std::size_t row = 0; row < session.samples.size(); ++row) {
      EXPECT_EQ(judged.session.samples[row].q, session.samples[row].q_command);
    }
  }
}

TEST(JointValues, ARobotThatStopsShortIsKnownByItsEncoders) {
  for (std::uint64_t i = 0; i < kSessions; ++i) {
    const session::Session session = session_of(arm_with(2e-4, 0.0, kFirstSeed + 100 + i));
    const PlausibleSession judged = plausible(session);
    EXPECT_TRUE(told(judged, "read_joints_fit_better")) << kFirstSeed + 100 + i;
    for (std::size_t row = 0; row < session.samples.size(); ++row) {
      EXPECT_EQ(judged.session.samples[row].q, session.samples[row].q);
    }
  }
}

TEST(JointValues, WhatDiffersByLessThanAnyoneCanMeasureIsAlike) {
  for (std::uint64_t i = 0; i < kSessions; ++i) {
    const PlausibleSession judged =
        plausible(session_of(arm_with(0.0, 1e-7, kFirstSeed + 200 + i)));
    EXPECT_TRUE(told(judged, "commanded_joints_alike")) << kFirstSeed + 200 + i;
  }
}

TEST(JointValues, AnEchoIsCalledOne) {
  const PlausibleSession judged = plausible(session_of(arm_with(0.0, 0.0, kFirstSeed)));
  EXPECT_TRUE(told(judged, "joints_echo_command"));
}

TEST(JointValues, TheFiveBarsDialsTellItToo) {
  const PlausibleSession judged = plausible(session_with([](session::Session& each) {
    std::mt19937_64 generator(7);
    std::normal_distribution<double> off(0.0, 3e-4);
    for (session::Sample& sample : each.samples) {
      sample.q_command = sample.q;
      for (double& q : sample.q) q += off(generator);
    }
  }));
  EXPECT_TRUE(told(judged, "commanded_joints_fit_better"));
  EXPECT_EQ(judged.session.samples[5].q, judged.session.samples[5].q_command);
}

TEST(JointValues, AFewPosesDoNotTell) {
  const PlausibleSession judged = plausible(session_of(arm_with(0.0, 2e-4, kFirstSeed), 9));
  EXPECT_TRUE(told(judged, "few_poses_for_commands"));
}

/// Noise of the joint values has a size, in the tool, and no name.
TEST(JointValues, ScatterOfAnArmsJointsIsToldAsSuch) {
  std::uint64_t found = 0;
  for (std::uint64_t i = 0; i < kSessions; ++i) {
    ArmWorld world = arm_with(0.0, 3e-4, kFirstSeed + 300 + i);
    world.writes_commands = false;
    const DiagnosisResult result =
        diagnose(session_of(world, 225), {.seed = 1, .bootstrap = 0, .with_gain = false});
    for (const FoundCause& cause : result.causes) {
      EXPECT_TRUE(cause.is_data_fault()) << kFirstSeed + 300 + i << ": " << cause.id.name();
    }
    EXPECT_TRUE(result.unexplained.depends_on.empty()) << kFirstSeed + 300 + i;
    const auto& size = result.unexplained.scatter_size;
    if (size && size->in == diagnosis::ScatterIn::kJoints) ++found;
  }
  EXPECT_EQ(found, kSessions);
}

TEST(JointValues, NoiseOfTheInstrumentIsNotTakenForThatOfTheJoints) {
  for (std::uint64_t i = 0; i < kSessions; ++i) {
    ArmWorld world = arm_with(0.0, 0.0, kFirstSeed + 400 + i);
    world.writes_commands = false;
    const DiagnosisResult result =
        diagnose(session_of(world, 225), {.seed = 1, .bootstrap = 0, .with_gain = false});
    const auto& size = result.unexplained.scatter_size;
    EXPECT_FALSE(size && size->in == diagnosis::ScatterIn::kJoints) << kFirstSeed + 400 + i;
  }
}

/// What a file says of commanded values comes back out of it, and half a row is refused.
TEST(JointValues, CommandedValuesKeepTheirPlaceInFiles) {
  const session::Session session = session_of(arm_with(1e-3, 0.0, kFirstSeed), 12);
  ASSERT_EQ(session.samples[3].q_command.size(), session.samples[3].q.size());
  EXPECT_NE(session.samples[3].q_command, session.samples[3].q);
  session::Session measured_here = session;
  measured_here.csv_header.clear();
  for (session::Sample& sample : measured_here.samples) sample.source_row.clear();
  const std::string text = session::session_csv(measured_here);
  EXPECT_NE(text.find("q1_command_rad"), std::string::npos);
  const session::Session again =
      session::parse_session(text, "session.csv", session::rig_toml(session), "rig.toml", {});
  EXPECT_EQ(again.samples[3].q_command, session.samples[3].q_command);

  std::string half = text;
  const std::size_t row = half.find('\n') + 1;
  std::size_t field = row;
  const auto columns = std::count(
      text.begin(), text.begin() + static_cast<long>(text.find("q1_command_rad")), ',');
  for (long i = 0; i < columns; ++i) field = half.find(',', field) + 1;
  half.erase(field, half.find(',', field) - field);
  try {
    (void)session::parse_session(
        half, "session.csv", session::rig_toml(session), "rig.toml", {});
    ADD_FAILURE() << "half of the commanded values were taken";
  } catch (const session::DataError& error) {
    EXPECT_NE(std::string(error.what()).find("q1_command_rad"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("all joints or of none"), std::string::npos);
  }
}

}  // namespace
}  // namespace sixdial::studies
