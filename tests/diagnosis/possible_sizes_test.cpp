// Sizes that physics forbids: no effect that is never negative is named where the readings want
// it negative, whichever effect it is; and one that is there keeps its name though a part of it
// is zero.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "calibration/random.h"
#include "diagnosis/naming.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

using simulation::Effect;
using simulation::Place;

struct Forbidden {
  const Effect* effect;
  Place place;
};

/// All effects at all places that have a size which is never negative.
std::vector<Forbidden> forbidden_cases() {
  std::vector<Forbidden> result;
  const geometry::Rig rig = geometry::default_rig();
  for (const Effect* effect : simulation::all_effects()) {
    for (const Place& place : effect->places(rig)) {
      for (int k = 0; k < linear_count(*effect); ++k) {
        const auto size = simulation::parameter_at(*effect, place, k);
        if (!size || !size->never_negative) continue;
        result.push_back({effect, place});
        break;
      }
    }
  }
  return result;
}

class NeverNegative : public testing::TestWithParam<Forbidden> {
 protected:
  /// A session with this effect at `share` of its usual sizes, each drawn up to twice as large.
  [[nodiscard]] NamedCauses found_with(double share, std::uint64_t seed) const {
    calibration::RandomSequence random(seed, 9);
    std::vector<double> x;
    for (const simulation::EffectParameter& each : GetParam().effect->parameters) {
      x.push_back(share * each.sigma * random.uniform(1.0, 2.0));
    }
    const Session session =
        session_of({.effects = {{GetParam().effect, GetParam().place, x}}, .seed = seed});
    Readings readings(session.model, session.trials);
    return name_causes(readings);
  }
  [[nodiscard]] std::string name() const {
    return Hypothesis{GetParam().effect, GetParam().place}.name();
  }
};

TEST_P(NeverNegative, IsNotNamedWithTheOtherSign) {
  for (const std::uint64_t seed : {41U, 42U, 43U}) {
    const NamedCauses found = found_with(-4.0, seed);
    // Something is wrong, and is told in other words, or as noise.
    const bool told = !found.findings.empty() || !found.unknown.empty();
    EXPECT_TRUE(told || found.extended.shared || found.extended.s_mm > 2 * kNoise_mm)
        << "seed " << seed;
    for (const Finding& each : found.findings) EXPECT_NE(each.hypothesis.name(), name());
  }
}

TEST_P(NeverNegative, IsNamedWithTheRightSign) {
  for (const std::uint64_t seed : {51U, 52U, 53U}) {
    const NamedCauses found = found_with(4.0, seed);
    const bool named = std::ranges::any_of(found.findings, [&](const Finding& each) {
      return each.certain() && each.hypothesis.name() == name();
    });
    EXPECT_TRUE(named) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(
    , NeverNegative, testing::ValuesIn(forbidden_cases()), [](const auto& each) {
      return std::string(each.param.effect->cause) + "_" + each.param.place.name;
    });

TEST(PossibleSizes, MayBeBelowZeroByTheirUncertainty) {
  const geometry::Rig rig = geometry::default_rig();
  int named = 0;
  constexpr int kSessions = 6;
  for (int i = 0; i < kSessions; ++i) {
    // One joint gives, the other does not: half of the fits have the other below zero.
    const Session session = session_of(
        {.effects = {effect_of(rig, "joint_compliance", "joints", {8e-6, 0.0})},
         .seed = 60 + static_cast<std::uint64_t>(i)});
    Readings readings(session.model, session.trials);
    for (const Finding& each : name_causes(readings).findings) {
      named += each.certain() && each.hypothesis.name() == "joint_compliance@joints";
    }
  }
  EXPECT_GE(named, kSessions - 1);
}

}  // namespace
}  // namespace sixdial::diagnosis
