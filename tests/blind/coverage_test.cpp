// A small part of bench/coverage: intervals hold the truth about as often as they say.
#include "tests/blind/coverage.h"

#include <gtest/gtest.h>

#include <vector>

namespace sixdial::blind {
namespace {

// Parameters of one session are one draw at worst: a true coverage of 0.92 falls below these
// less than once in a thousand runs of so many sessions.
constexpr int kSessions = 60;
constexpr double kLeastShare = 0.84;

struct Coverage : testing::TestWithParam<CoverageCase> {};

TEST_P(Coverage, IsAboutWhatIsStated) {
  Share parameters, positions;
  for (std::uint64_t seed = 9'000; seed < 9'000 + kSessions; ++seed) {
    const auto covered = try_coverage(GetParam(), seed);
    if (!covered) continue;
    parameters.inside += covered->parameters.inside;
    parameters.of += covered->parameters.of;
    positions.inside += covered->positions.inside;
    positions.of += covered->positions.of;
  }
  ASSERT_GT(parameters.of, 5 * kSessions);
  EXPECT_GE(parameters.inside, kLeastShare * parameters.of);
  EXPECT_GE(positions.inside, kLeastShare * positions.of);
}

INSTANTIATE_TEST_SUITE_P(
    Cases, Coverage,
    testing::Values(
        CoverageCase{.points = 9, .noise_times = 3.0}, CoverageCase{.points = 30},
        CoverageCase{.points = 30, .warp_mm = 0.01},
        CoverageCase{.points = 33, .repeats = Repeats::kAtRest},
        CoverageCase{.dials = true, .points = 9, .noise_times = 3.0},
        CoverageCase{.dials = true, .points = 30},
        // What moves the tool is seen by all dials at once: not a function of each for itself.
        CoverageCase{.dials = true, .points = 30, .warp_mm = 0.01}));

}  // namespace
}  // namespace sixdial::blind
