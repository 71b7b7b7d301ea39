// The limits that a verdict states mean what they say.
#include <gtest/gtest.h>

#include "tests/blind/limit_power.h"

namespace sixdial::blind {
namespace {

double share(int k, int of) { return static_cast<double>(k) / of; }

struct Power {
  int n[2] = {}, detected[2] = {}, named[2] = {},
      wrong = 0;  // at the limit of detection, of naming
};
Power power_of(RigFile file, int sessions) {
  Power power;
  for (std::uint64_t seed = 8000; seed < 8000 + static_cast<std::uint64_t>(sessions); ++seed) {
    for (const AtLimit& each : try_limits(seed, file)) {
      ++power.n[each.of_name];
      power.detected[each.of_name] += each.detected;
      power.named[each.of_name] += each.named;
      power.wrong += each.wrong;
    }
  }
  return power;
}

TEST(StatedLimits, HaveAboutThePowerThatTheyState) {
  const Power of = power_of(RigFile::kExact, 6);
  ASSERT_GT(of.n[0], 90);
  ASSERT_GT(of.n[1], 90);
  // 80 % of a hundred, three standard deviations and what some causes lack (doc/diagnosis.md).
  EXPECT_GT(share(of.detected[0], of.n[0]), 0.66);
  EXPECT_LT(share(of.detected[0], of.n[0]), 0.92);
  EXPECT_GT(share(of.named[1], of.n[1]), 0.63);
  EXPECT_LT(share(of.named[1], of.n[1]), 0.92);
  EXPECT_GT(share(of.detected[1], of.n[1]), 0.85);
  EXPECT_LT(share(of.wrong, of.n[0] + of.n[1]), 0.06);
}

/// With random columns in the fit: what the file states of the rig, and the dials' curves.
TEST(StatedLimits, HaveItOnARigThatIsKnownRoughlyToo) {
  const Power of = power_of(RigFile::kDeviations, 4);
  ASSERT_GT(of.n[0], 50);
  ASSERT_GT(of.n[1], 50);
  // 80 % of seventy, three standard deviations and what some causes lack.
  EXPECT_GT(share(of.detected[0], of.n[0]), 0.62);
  EXPECT_LT(share(of.detected[0], of.n[0]), 0.94);
  EXPECT_GT(share(of.named[1], of.n[1]), 0.58);
  EXPECT_LT(share(of.named[1], of.n[1]), 0.94);
}

}  // namespace
}  // namespace sixdial::blind
