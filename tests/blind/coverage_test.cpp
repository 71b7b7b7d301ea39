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

// Few sessions: of shares of 0.95, less than 0.75 comes by chance once in a thousand runs.
TEST(CoverageOfADiagnosis, SizesAndGainsHoldTheTruth) {
  constexpr int kDrawn = 38;  // each cause twice
  constexpr double kLeast = 0.75;
  Share sizes, gain;
  for (std::uint64_t seed = 9'500; seed < 9'500 + kDrawn; ++seed) {
    const CoverageCase of{
        .dials = true, .points = 40, .diagnosis = true, .cause = std::string(kAnyCause)};
    const auto covered = try_coverage(of, seed);
    if (!covered) continue;
    sizes.inside += covered->amplitudes.inside;
    sizes.of += covered->amplitudes.of;
    gain.inside += covered->gain.inside;
    gain.of += covered->gain.of;
  }
  ASSERT_GT(sizes.of, kDrawn / 2);
  ASSERT_GT(gain.of, kDrawn / 3);
  EXPECT_GE(sizes.inside, kLeast * sizes.of);
  EXPECT_GE(gain.inside, kLeast * gain.of);
}

TEST(CoverageOfADiagnosis, OfNoiseAloneSaysNothing) {
  int alarms = 0;
  for (const Repeats repeats : {Repeats::kNone, Repeats::kAtRest}) {
    for (std::uint64_t seed = 9'600; seed < 9'615; ++seed) {
      const CoverageCase of{.dials = true, .points = 15, .repeats = repeats, .diagnosis = true};
      const auto covered = try_coverage(of, seed);
      alarms += covered && covered->false_alarm ? 1 : 0;
    }
  }
  EXPECT_LE(alarms, 3);  // at 2 %, four of 30 come by chance once in 300 runs
}

}  // namespace
}  // namespace sixdial::blind
