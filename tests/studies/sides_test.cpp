// Sides from which the joints came: recorded with the other sign, or by nobody. Sessions of the
// mock rig with a backlash.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mock_devices/session_generator.h"
#include "session/bundle.h"
#include "studies/diagnose.h"

namespace sixdial::studies {
namespace {

session::Session with_backlash(const char* joint, double size_rad, std::uint64_t seed) {
  mock_devices::World world;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  world.dials = {0.002, 0.001, 0.0, 0.0};
  world.seed = seed;
  world.effects = {
      mock_devices::make_effect(world.rig, "joint_backlash", joint, size_rad, seed)};
  return session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(world, mock_devices::random_plan(world.rig, seed)),
          world.rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(world.rig), "rig.toml");
}

DiagnosisResult diagnosed(const session::Session& session) {
  return diagnose(session, {.bootstrap = 0, .with_gain = true});
}

const Warning* told(const DiagnosisResult& result, std::string_view code) {
  const auto found = std::ranges::find(*result.warnings, code, &Warning::code);
  return found == result.warnings->end() ? nullptr : &*found;
}

/// Its names and, of one that may be nothing, that it may.
std::string said_by(const DiagnosisResult& result) {
  std::string said;
  for (const FoundCause& cause : result.causes) {
    said += cause.id.name() + (cause.is_doubtful() ? "? " : " ");
  }
  return said;
}

/// Backlash of that joint, of its true size, and sure; and nothing else but what may be nothing
/// at all, as in one such session of forty, and readings of a tip at the end of its face, where
/// the drawn poses of the mock rig have some.
void expect_backlash(const DiagnosisResult& result, const char* joint, double size_rad) {
  ASSERT_FALSE(result.causes.empty());
  const FoundCause& backlash = result.causes[0];
  EXPECT_EQ(backlash.id.name(), std::string("joint_backlash@") + joint);
  EXPECT_EQ(backlash.certainty(), Certainty::kCertain);
  EXPECT_EQ(backlash.standing, Standing::kConfirmed);
  EXPECT_LT(std::abs(backlash.estimate.at(0).value - size_rad), 4 * backlash.estimate.at(0).sd);
  for (std::size_t i = 1; i < result.causes.size(); ++i) {
    const FoundCause& other = result.causes[i];
    EXPECT_TRUE(other.is_data_fault() || other.is_doubtful()) << said_by(result);
    EXPECT_TRUE(other.is_data_fault() || other.standing != Standing::kConfirmed);
  }
  for (const GrossReading& each : result.gross_readings) EXPECT_TRUE(each.near_edge);
}

TEST(Sides, WithTheOtherSignAreToldAndTurnedRound) {
  for (const std::size_t reversed : {0U, 1U, 2U}) {  // 2: both joints
    session::Session session = with_backlash("joint2", 4e-4, 50 + reversed);
    const DiagnosisResult right = diagnosed(session);
    for (session::Sample& sample : session.samples) {
      for (std::size_t joint = 0; joint < sample.approach.size(); ++joint) {
        auto& side = sample.approach[joint];
        if (side && (reversed == 2 || joint == reversed)) side = -*side;
      }
    }
    const DiagnosisResult result = diagnosed(session);
    expect_backlash(result, "joint2", 4e-4);
    EXPECT_EQ(said_by(result), said_by(right));
    EXPECT_EQ(result.causes[0].delta_bic, right.causes[0].delta_bic) << "the same sides";
    ASSERT_NE(told(result, "sides_reversed"), nullptr);
    EXPECT_EQ(
        std::ranges::count(*result.warnings, "sides_reversed", &Warning::code),
        reversed == 2 ? 2 : 1);
  }
}

TEST(Sides, ThatNobodyRecordedAreThoseOfTheMoves) {
  for (const char* joint : {"joint1", "joint2"}) {
    session::Session session = with_backlash(joint, 4e-4, 60);
    for (session::Sample& sample : session.samples) sample.approach.clear();
    const DiagnosisResult result = diagnosed(session);
    expect_backlash(result, joint, 4e-4);
    EXPECT_NE(told(result, "sides_from_rows"), nullptr);
  }
}

TEST(Sides, AsTheyWereAreNoMatterOfDoubt) {
  const DiagnosisResult result = diagnosed(with_backlash("joint1", 4e-4, 70));
  expect_backlash(result, "joint1", 4e-4);
  EXPECT_EQ(told(result, "sides_reversed"), nullptr);
  EXPECT_EQ(told(result, "sides_from_rows"), nullptr);
}

// A clearance that stands for a backlash which has no column would be the wrong repair; a
// backlash less than nothing cannot be.
TEST(Sides, ThatSayTheOppositeOfSomeMovesConfirmNoNegativeBacklash) {
  session::Session session = with_backlash("joint2", 4e-4, 80);
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    if (i % 5 == 0) continue;  // four of five
    for (auto& side : session.samples[i].approach) {
      if (side) side = -*side;
    }
  }
  const DiagnosisResult result = diagnosed(session);
  for (const FoundCause& cause : result.causes) {
    if (cause.id.cause == "joint_backlash") {
      EXPECT_GE(cause.estimate.at(0).value, 0.0);
    }
  }
}

}  // namespace
}  // namespace sixdial::studies
