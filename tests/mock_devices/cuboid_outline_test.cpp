// The mock's own contact solver against closed forms and against geometry/contact, which solves
// the same question another way.
#include "mock_devices/cuboid_outline.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/instruments/contact.h"
#include "geometry/rig.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr double kAgreement_mm = 1e-9;  // two closed computations at 100 mm, far from corners
constexpr double kSide_mm = 80.0;
constexpr double kTravel_mm = 50.8;

TEST(CuboidOutline, ASharpTipOnAnUprightFaceReadsThePlainDifference) {
  const CuboidOutline outline({28, 48}, 0.0, kSide_mm, 0.0);
  // Dial B of spec 1: left face at x = -12, tip at x = 4.
  const auto push = push_of(outline, {{4, 48}, {1, 0}, 0.0}, kTravel_mm);
  ASSERT_TRUE(push);
  EXPECT_NEAR(push->displacement_mm, 16.0, kAgreement_mm);
  EXPECT_FALSE(push->on_corner);
  EXPECT_LT((push->by_position - Vector2d(-1, 0)).norm(), 1e-12);
}

TEST(CuboidOutline, ABallOnATurnedFaceReadsMoreByItsSecant) {
  // With gamma the ball costs rho (1/cos gamma - 1) against a sharp tip, spec 1.
  const double gamma = 20.0 * std::numbers::pi / 180.0;
  const CuboidOutline outline({28, 48}, gamma, kSide_mm, 0.0);
  const auto sharp = push_of(outline, {{4, 48}, {1, 0}, 0.0}, kTravel_mm);
  const auto ball = push_of(outline, {{4, 48}, {1, 0}, 1.5}, kTravel_mm);
  ASSERT_TRUE(sharp && ball);
  EXPECT_NEAR(
      ball->displacement_mm - sharp->displacement_mm, 1.5 * (1 / std::cos(gamma) - 1),
      kAgreement_mm);
}

TEST(CuboidOutline, ABallOnACornerIsOneRadiusAwayFromIt) {
  const CuboidOutline outline({0, 0}, 0.0, kSide_mm, 0.0);
  // The axis passes 1 mm above the upper left corner (-40, 40): a ball of 1.5 mm catches it.
  const auto push = push_of(outline, {{-30, 41}, {1, 0}, 1.5}, kTravel_mm);
  ASSERT_TRUE(push);
  EXPECT_TRUE(push->on_corner);
  const double ball_x = -30 - 1.5 - push->displacement_mm;
  EXPECT_NEAR(std::hypot(ball_x + 40, 1.0), 1.5, kAgreement_mm);
  EXPECT_LT(ball_x, -40.0);  // on the dial's side of the corner
}

TEST(CuboidOutline, ATipThatPassesByOrFallsShortTouchesNothing) {
  const CuboidOutline outline({0, 0}, 0.3, kSide_mm, 0.0);
  EXPECT_FALSE(push_of(outline, {{-30, 90}, {1, 0}, 1.5}, kTravel_mm));
  EXPECT_FALSE(push_of(outline, {{-60, 0}, {1, 0}, 1.5}, kTravel_mm));
  EXPECT_FALSE(push_of(outline, {{-60, 0}, {0, 1}, 1.5}, kTravel_mm));
}

TEST(CuboidOutline, BeyondTheTravelThePushIsStillTheTrueOne) {
  const CuboidOutline outline({0, 0}, 0.0, kSide_mm, 0.0);
  const auto push = push_of(outline, {{20, 0}, {1, 0}, 1.5}, kTravel_mm);
  ASSERT_TRUE(push);
  EXPECT_NEAR(push->displacement_mm, 60.0, kAgreement_mm);
}

TEST(CuboidOutline, AShearedCuboidTurnsTwoOfItsFaces) {
  const double shear = 0.01;
  const CuboidOutline outline({0, 0}, 0.0, kSide_mm, shear);
  // Right face unturned; upper face at distance 40 along (cos, sin)(90 deg + shear).
  const auto right = push_of(outline, {{30, 5}, {-1, 0}, 0.0}, kTravel_mm);
  const auto top = push_of(outline, {{10, 30}, {0, -1}, 0.0}, kTravel_mm);
  ASSERT_TRUE(right && top);
  EXPECT_NEAR(right->displacement_mm, 10.0, kAgreement_mm);
  EXPECT_NEAR(
      top->displacement_mm, (40 + 10 * std::sin(shear)) / std::cos(shear) - 30, kAgreement_mm);
}

TEST(CuboidOutline, AgreesWithTheFaceModelOnRandomPosesAndRigs) {
  const geometry::Rig rig = geometry::default_rig();
  const Random random(20260302, Stream::kRobot);
  int touching = 0;
  int not_touching = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const std::uint64_t c = 8 * i;
    const geometry::CuboidPose pose{
        {random.uniform(c, 0, 56), random.uniform(c + 1, 20, 76)},
        random.uniform(c + 2, -0.5, 0.5)};
    geometry::DialGeometry dial = rig.dials[i % 6].geometry;
    const double lean = random.uniform(c + 3, -0.1, 0.1);
    dial.axis = Eigen::Rotation2Dd(lean) * dial.axis;
    dial.tip_radius_mm = random.uniform(c + 4, 0.0, 3.0);
    const CuboidOutline outline(pose.p_WE, pose.gamma_rad, kSide_mm, 0.0);
    const auto push =
        push_of(outline, {dial.position_mm, dial.axis, dial.tip_radius_mm}, dial.travel_mm);
    const auto contact = geometry::touch(dial, pose, kSide_mm);
    if (contact) {
      ++touching;
      ASSERT_TRUE(push);
      ASSERT_NEAR(push->displacement_mm, contact->displacement_mm, kAgreement_mm);
      ASSERT_FALSE(push->on_corner);
      ASSERT_LT((push->by_position - contact->J.head<2>().transpose()).norm(), 1e-9);
    } else if (contact.error() == geometry::ContactTrouble::kNoTouch) {
      ++not_touching;
      ASSERT_FALSE(push);
    }
  }
  EXPECT_GT(touching, 10'000);
  EXPECT_GT(not_touching, 500);
}

}  // namespace
}  // namespace sixdial::mock_devices
