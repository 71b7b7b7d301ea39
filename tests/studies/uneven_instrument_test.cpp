// An instrument that states another standard deviation for each reading.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "studies/diagnose.h"
#include "tests/support/arm_session.h"

namespace sixdial::studies {
namespace {

/// A tracker's readings are the less sure the farther off they are: sigma is drawn for each
/// pose, and the readings scatter by it.
session::Session with_uneven_readings(std::uint64_t seed, double last_sd_mm) {
  session::Session session = session::arm_session(90, 60);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> factor(0.5, 4.0);
  for (session::Sample& sample : session.samples) {
    const bool last = &sample == &session.samples.back();
    const double sd_mm = last ? last_sd_mm : 0.01 * factor(engine);
    for (session::ChannelValue& channel : sample.channels) {
      channel.value = *channel.value + sd_mm * normal(engine);
    }
    // The 0.01 mm that every pose of arm_session has, too.
    sample.position_sd_mm.assign(3, std::hypot(0.01, sd_mm));
  }
  return session;
}

/// It was taken for a dial that scatters more than the others, where there are no dials.
TEST(UnevenInstrument, WithoutDialsIsDiagnosedWhereverTheUnsureReadingStands) {
  for (const double last_sd_mm : {0.005, 0.2}) {
    const DiagnosisResult result = diagnose(
        with_uneven_readings(7, last_sd_mm),
        {.bootstrap = 0, .with_gain = false, .threads = 1});
    EXPECT_TRUE(result.causes.empty()) << last_sd_mm;
    EXPECT_TRUE(result.unexplained.noisy_dials.empty()) << last_sd_mm;
  }
}

}  // namespace
}  // namespace sixdial::studies
