// What each dial should show at a pose, and what cannot be true.
#include "acquisition/plausibility.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using session::Quality;
using testing::HasSubstr;

TEST(Plausible, SwappedDialsAreNamed) {
  const geometry::Rig rig = geometry::default_rig();
  const Plausibility plausibility(rig, 5.0);
  const auto q = geometry::inverse(rig.robot.nominal, {36, 44}, rig.robot.working_mode).value();
  const auto expected = plausibility.expected_at(q);
  std::vector<Reading> readings;
  for (const auto& each : expected) {
    readings.push_back(good_reading(each.displacement_mm.value(), DeviceTime{0}, {}));
  }
  ASSERT_GT(std::abs(*readings[0].value_mm - *readings[1].value_mm), 5.0);
  auto straight = readings;
  plausibility.judge(straight, expected);
  for (const auto& each : straight) EXPECT_EQ(each.quality, Quality::kGood);
  std::swap(readings[0].value_mm, readings[1].value_mm);
  plausibility.judge(readings, expected);
  EXPECT_THAT(readings[0].detail, HasSubstr("would fit dial B"));
  EXPECT_THAT(readings[1].detail, HasSubstr("would fit dial A"));
  EXPECT_EQ(readings[2].quality, Quality::kGood);
}

TEST(Plausible, AFreeCuboidAllowsNoExpectation) {
  geometry::Rig rig = geometry::default_rig();
  rig.cuboid.mount = geometry::Mount::kFree;
  for (const auto& each : Plausibility(rig, 5.0).expected_at(Eigen::Vector2d(1.0, 2.0))) {
    EXPECT_FALSE(each.displacement_mm);
    EXPECT_FALSE(each.off_face);
  }
}

}  // namespace
}  // namespace sixdial::acquisition
