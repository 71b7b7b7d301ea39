// A dial whose scale is uneven far beyond its maker's limit: which dial, how wide, how it bends
// and which robot are drawn. It is found as what it is, and gets no other name: one wave with a
// scale and a shift beside it describes nearly any smooth curve.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "mock_devices/session_generator.h"
#include "tests/blind/challenge.h"

namespace sixdial::blind {
namespace {

constexpr int kSessions = 6;

struct Verdict {
  diagnosis::NamedCauses names;
  std::string dial;
  std::string said;
};

/// A rig with a curve of that rms at a drawn dial, and nothing else.
mock_devices::World world_of(std::uint64_t seed, double rms_mm) {
  std::mt19937_64 engine(seed);
  mock_devices::World world;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  world.seed = seed;
  world.dials.hysteresis_mm = 0.0;
  world.dials.curve_mm = 0.0;
  const std::string dial = world.rig.dials[engine() % world.rig.dials.size()].id;
  world.effects = {mock_devices::make_effect(world.rig, "dial_curve", dial, rms_mm, seed)};
  return world;
}

/// `accuracy_mm`: what the rig file allows that dial.
Verdict diagnosed(std::uint64_t seed, double rms_mm, double accuracy_mm = 0.006) {
  mock_devices::World world = world_of(seed, rms_mm);
  const std::string dial = world.effects.front().where;
  std::ranges::find(world.rig.dials, dial, &geometry::Dial::id)->accuracy_mm = accuracy_mm;
  const auto session =
      mock_devices::generate_session(world, mock_devices::random_plan(world.rig, seed));
  const simulation::ForwardModel model(world.rig);
  diagnosis::Readings readings(model, trials_of(world.rig, session));
  Verdict verdict{diagnosis::name_causes(readings), dial, ""};
  for (const diagnosis::Finding& each : verdict.names.findings) {
    verdict.said += each.hypothesis.name() + (each.certain() ? " " : "~ ");
  }
  for (const diagnosis::DialCurve& each : verdict.names.dial_curves) {
    verdict.said += "curve of " + world.rig.dials[each.dial].id + " ";
  }
  for (const std::string& each : verdict.names.depends_on()) verdict.said += "? " + each + " ";
  return verdict;
}

TEST(UnevenDial, IsNamedAndNothingElseIs) {
  int named = 0;
  int seen = 0;
  for (std::uint64_t seed = 1; seed <= kSessions; ++seed) {
    std::mt19937_64 engine(seed * 977);
    const double rms_mm =
        0.015 * std::pow(6.0, std::uniform_real_distribution<double>(0.0, 1.0)(engine));
    const Verdict verdict = diagnosed(seed, rms_mm);
    SCOPED_TRACE(
        "seed " + std::to_string(seed) + ": " + verdict.dial + " " + std::to_string(rms_mm) +
        " mm, said " + verdict.said);
    const std::vector<std::string> own{"dial " + verdict.dial + " reading"};
    const std::vector<std::string> depends_on = verdict.names.depends_on();
    bool in_set = std::ranges::count(depends_on, own.front()) > 0;
    for (const diagnosis::Finding& each : verdict.names.findings) {
      EXPECT_FALSE(each.certain()) << each.hypothesis.name();
      in_set = in_set || each.tied_with_unknown == own;
    }
    for (const diagnosis::DialCurve& each : verdict.names.dial_curves) {
      EXPECT_EQ(geometry::default_rig().dials[each.dial].id, verdict.dial);
      EXPECT_GT(each.half_span, each.limit_mm);
      EXPECT_LT(each.half_span, 4 * rms_mm);
      in_set = true;
      named += each.certain() ? 1 : 0;
    }
    seen += in_set ? 1 : 0;
  }
  // Of 40 drawn sessions: 30 named for sure, six tied with other things, two found without a
  // name, in two the dial was called noisy.
  EXPECT_GE(seen, kSessions - 1);
  EXPECT_GE(named, kSessions / 2);
}

TEST(UnevenDial, IsConfirmedWhereBothSetsShowIt) {
  constexpr std::uint64_t kSeed = 2;
  mock_devices::World world = world_of(kSeed, 0.03);
  const auto plan = mock_devices::random_plan(world.rig, kSeed);
  auto session = mock_devices::generate_session(world, plan);
  const auto dial = static_cast<std::size_t>(
      std::ranges::find(world.rig.dials, world.effects.front().where, &geometry::Dial::id) -
      world.rig.dials.begin());
  world.effects.clear();
  const auto healthy = mock_devices::generate_session(world, plan);
  const simulation::ForwardModel model(world.rig);
  std::vector<bool> in_g2;
  for (const auto& row : session.rows) in_g2.push_back(row.planned.set == "G2");
  const diagnosis::DiagnosisSettings quick{
      .null_draws = 0, .with_gain = false, .with_limits = false};

  const auto both = diagnosis::diagnose(model, trials_of(world.rig, session), in_g2, quick);
  ASSERT_EQ(both.named.dial_curves.size(), 1U);
  EXPECT_EQ(both.named.dial_curves[0].dial, dial);
  EXPECT_TRUE(both.named.dial_curves[0].on_g1);
  EXPECT_TRUE(both.named.dial_curves[0].confirmed);

  // The dial was repaired before G2 was measured: no session that confirms a curve.
  for (std::size_t i = 0; i < session.rows.size(); ++i) {
    if (in_g2[i]) session.rows[i].dial_mm[dial] = healthy.rows[i].dial_mm[dial];
  }
  const auto first = diagnosis::diagnose(model, trials_of(world.rig, session), in_g2, quick);
  for (const diagnosis::DialCurve& each : first.named.dial_curves) {
    EXPECT_FALSE(each.confirmed) << each.g2_log_odds;
  }
}

TEST(UnevenDial, WithinWhatItsMakerAllowsIsNoFinding) {
  constexpr std::uint64_t kSeed = 2;
  constexpr double kRms_mm = 0.03;
  EXPECT_EQ(diagnosed(kSeed, kRms_mm).names.dial_curves.size(), 1U);
  const Verdict allowed = diagnosed(kSeed, kRms_mm, 0.2);
  EXPECT_TRUE(allowed.names.dial_curves.empty()) << allowed.said;
}

}  // namespace
}  // namespace sixdial::blind
