// Arms whose joints give under weight, with masses that are not alike: where the links' masses
// lie is nobody's fault, and gets no name of its own at the same joint.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "mock_devices/arm_world.h"
#include "session/bundle.h"
#include "studies/diagnose.h"
#include "tests/blind/robot_outcome.h"

namespace sixdial::blind {
namespace {

using mock_devices::ArmWorld;

constexpr int kSessions = 6;
constexpr std::uint64_t kFirstSeed = 7300;

/// An arm that gives at a drawn joint, or with `all` at each, by so much that masses which are
/// not alike show above the noise.
ArmWorld sagging(std::uint64_t seed, bool all) {
  std::mt19937_64 engine(seed);
  ArmWorld world = mock_devices::drawn_arm(seed, 6);
  world.noise_mm = 0.01;
  const std::vector<std::string> places =
      mock_devices::places_at_arm(world, "joint_gravity_compliance");
  const std::size_t drawn = engine() % 2;  // joint 2 or 3: those that carry most
  std::uniform_real_distribution<double> size(5e-4, 1e-3);
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (!all && k != drawn) continue;
    world.effects.push_back(mock_devices::make_arm_effect(
        world, "joint_gravity_compliance", places[k], size(engine)));
  }
  return world;
}

/// Certain names that are not in the world; and whether each of the world's was named or tied.
struct Verdict {
  std::string wrong, said;
  bool named = false;
};

Verdict verdict_on(const ArmWorld& world, std::uint64_t seed) {
  const ChallengeFolder folder("masses", seed);
  write_arm_bundle(folder.path(), measure_arm(world, 150, 75), world);
  RobotOutcome outcome;
  for (const mock_devices::ArmEffect& each : world.effects) {
    outcome.truth.push_back(each.cause + "@" + each.where);
  }
  const studies::DiagnosisRequest quick{
      .seed = 1, .bootstrap = 0, .with_gain = false, .threads = 1};
  const auto result = studies::diagnose(session::read_bundle(folder.path().string()), quick);
  judge(result, outcome);
  return {outcome.wrong ? outcome.said : "", outcome.said, outcome.named || outcome.in_tie};
}

TEST(UnequalMasses, GetNoNameBesideOneJointThatGives) {
  int named = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kSessions; ++seed) {
    const ArmWorld world = sagging(seed, false);
    const Verdict verdict = verdict_on(world, seed);
    EXPECT_EQ(verdict.wrong, "") << "seed " << seed << ", " << world.effects[0].where;
    named += verdict.named;
  }
  EXPECT_GE(named, kSessions - 1);
}

TEST(UnequalMasses, GetNoNameBesideJointsThatAllGive) {
  for (std::uint64_t seed = kFirstSeed + 50; seed < kFirstSeed + 50 + kSessions / 2; ++seed) {
    const Verdict verdict = verdict_on(sagging(seed, true), seed);
    EXPECT_EQ(verdict.wrong, "") << "seed " << seed << ": " << verdict.said;
  }
}

/// What is there beside the weight keeps its name where weight cannot look like it.
TEST(UnequalMasses, DoNotHideABacklash) {
  int named = 0;
  for (std::uint64_t seed = kFirstSeed + 80; seed < kFirstSeed + 80 + kSessions / 2; ++seed) {
    ArmWorld world = sagging(seed, false);
    const std::string where = world.effects[0].where;
    world.effects.push_back(
        mock_devices::make_arm_effect(world, "joint_backlash", where, 3e-4));
    const Verdict verdict = verdict_on(world, seed);
    EXPECT_EQ(verdict.wrong, "") << "seed " << seed;
    named += verdict.named;
  }
  EXPECT_GE(named, kSessions / 2 - 1);
}

}  // namespace
}  // namespace sixdial::blind
