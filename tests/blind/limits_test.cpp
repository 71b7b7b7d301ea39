// The limits that a verdict states mean what they say.
#include <gtest/gtest.h>

#include "tests/blind/limit_power.h"

namespace sixdial::blind {
namespace {

TEST(StatedLimits, HaveAboutThePowerThatTheyState) {
  constexpr int kSessions = 6;
  int n[2] = {}, detected[2] = {}, named[2] = {}, wrong = 0;
  for (std::uint64_t seed = 8000; seed < 8000 + kSessions; ++seed) {
    for (const AtLimit& each : try_limits(seed)) {
      ++n[each.of_name];
      detected[each.of_name] += each.detected;
      named[each.of_name] += each.named;
      wrong += each.wrong;
    }
  }
  ASSERT_GT(n[0], 90);
  ASSERT_GT(n[1], 90);
  // 80 % of a hundred, three standard deviations and what some causes lack (doc/diagnosis.md).
  const auto share = [](int k, int of) { return static_cast<double>(k) / of; };
  EXPECT_GT(share(detected[0], n[0]), 0.66);
  EXPECT_LT(share(detected[0], n[0]), 0.92);
  EXPECT_GT(share(named[1], n[1]), 0.63);
  EXPECT_LT(share(named[1], n[1]), 0.92);
  EXPECT_GT(share(detected[1], n[1]), 0.85);
  EXPECT_LT(share(wrong, n[0] + n[1]), 0.06);
}

}  // namespace
}  // namespace sixdial::blind
