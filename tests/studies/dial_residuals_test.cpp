// What parameters leave of each dial: nothing at the truth, a constant where a dial stands
// wrong.
#include "studies/dial_residuals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "geometry/rig.h"
#include "mock_devices/session_generator.h"
#include "session/bundle.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

session::Session made_session(const mock_devices::World& world) {
  testing::TempDirectory directory;
  mock_devices::write_bundle(
      directory.path(),
      mock_devices::generate_session(world, mock_devices::random_plan(world.rig, 4, 60, 20)),
      world.rig, "2026-03-02T08:30:00.000Z");
  return session::read_bundle(directory.path().string());
}

mock_devices::World quiet_world() {
  mock_devices::World world;
  world.dials = mock_devices::kIdealDials;
  world.robot = mock_devices::drawn_robot(world.rig, 7);
  return world;
}

TEST(DialResiduals, VanishAtTheTruth) {
  constexpr double kWritten_mm = 6e-4;  // readings are written to 0.001 mm
  const mock_devices::World world = quiet_world();
  const auto rows =
      dial_residuals(made_session(world), world.rig.robot.nominal, world.robot.parameters);
  ASSERT_EQ(rows.size(), 6U);
  for (const DialRow& row : rows) {
    EXPECT_GT(row.readings, 20) << row.dial;
    EXPECT_LT(std::abs(row.median_mm), kWritten_mm) << row.dial;
    EXPECT_LT(row.spread_mm, kWritten_mm) << row.dial;
    EXPECT_GT(std::abs(row.before_median_mm), 0.05) << row.dial;  // mm: an uncalibrated robot
  }
}

TEST(DialResiduals, ADialThatStandsElsewhereIsOffByThat) {
  constexpr double kShift_mm = 0.050;
  constexpr double kLeverage_mm = 0.002;  // of the rotation that this dial helps to give
  mock_devices::World world = quiet_world();
  world.effects.push_back(
      mock_devices::make_effect(world.rig, "dial_mount", "B", kShift_mm, 1));
  const auto rows =
      dial_residuals(made_session(world), world.rig.robot.nominal, world.robot.parameters);
  for (const DialRow& row : rows) {
    if (row.dial == "B") {
      EXPECT_NEAR(std::abs(row.median_mm), kShift_mm, kLeverage_mm);
    } else {
      EXPECT_LT(std::abs(row.median_mm), kLeverage_mm) << row.dial;
    }
  }
}

TEST(DialResiduals, AFreeMountNeedsNoClampAngle) {
  mock_devices::World world = quiet_world();
  world.rig.cuboid.mount = geometry::Mount::kFree;
  const auto rows =
      dial_residuals(made_session(world), world.rig.robot.nominal, world.robot.parameters);
  constexpr double kWritten_mm = 8e-4;  // readings, and with them the rotation, to 0.001 mm
  ASSERT_FALSE(rows.empty());
  for (const DialRow& row : rows) EXPECT_LT(row.spread_mm, kWritten_mm) << row.dial;
}

}  // namespace
}  // namespace sixdial::studies
