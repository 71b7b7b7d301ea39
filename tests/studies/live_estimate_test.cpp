// What the estimate that grows with a collection says of each sample: worth another look or
// not.
#include "studies/live_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using testing::measured;
using testing::simple_world;

const geometry::Rig kRig = geometry::default_rig();

// With few samples nobody knows what is usual: a warped robot is off by many times its dials'
// noise, everywhere, and no sample of it is worth another look.
TEST(LiveEstimate, SuspectsNoSampleOfARobotThatIsBentEverywhere) {
  int told = 0;
  int suspected = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    mock_devices::World world = simple_world(seed);
    world.warp.amplitude_mm = 0.02;
    world.warp.wavelength_mm = 40;
    const session::Session session =
        measured(world, session::plan_random(kRig, 40, {.seed = seed}).value());
    LiveEstimate estimate(kRig, points_of(session));
    for (const session::Sample& sample : session.samples) {
      if (!estimate.add(sample)) continue;
      ++told;
      suspected += estimate.last_unusual();
    }
  }
  EXPECT_GT(told, 400);
  EXPECT_LE(suspected, told / 100);
}

TEST(LiveEstimate, SuspectsAWrongReadingOnceTenSamplesAreThere) {
  for (const int at : {10, 20, 35}) {
    session::Session session =
        measured(simple_world(3), session::plan_random(kRig, 40, {.seed = 4}).value());
    for (auto& dial : session.samples[static_cast<std::size_t>(at)].channels) {
      if (dial.value) *dial.value += 0.5;
    }
    LiveEstimate estimate(kRig, points_of(session));
    for (int i = 0; i <= at; ++i) {
      estimate.add(session.samples[static_cast<std::size_t>(i)]);
      EXPECT_EQ(estimate.last_unusual(), i == at) << i;
    }
  }
}

// P(F(2, n) > f) = (1 + 2 f / n)^(-n / 2) is one in a million.
TEST(LiveEstimate, SaysFromWhereOnByTheSamplesThatThereAre) {
  const auto freedom = [](int samples) { return 2 * samples - geometry::kParameterCount; };
  EXPECT_TRUE(std::isinf(unusual_from(freedom(0))));
  EXPECT_TRUE(std::isinf(unusual_from(freedom(5))));
  const int n = freedom(9);
  const double early = unusual_from(n);
  EXPECT_NEAR(std::pow(1 + 2 * early * early / n, -n / 2.0) / 1e-6, 1.0, 1e-6);
  EXPECT_EQ(unusual_from(freedom(100)), kUnusual);
  for (int samples = 6; samples < 60; ++samples) {
    EXPECT_LE(unusual_from(freedom(samples + 1)), unusual_from(freedom(samples)));
  }
}

}  // namespace
}  // namespace sixdial::studies
