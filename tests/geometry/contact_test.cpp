#include "geometry/instruments/contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/rig.h"

namespace sixdial::geometry {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSharp_mm = 1e-12;   // issue: equation (39) against the general form
constexpr double kSolved_mm = 1e-10;  // three lines intersected at 100 mm
constexpr double kSide_mm = 80.0;

double drawn(std::mt19937_64& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

CuboidPose drawn_pose(std::mt19937_64& engine, double most_gamma = 0.4) {
  return {
      {drawn(engine, 16, 40), drawn(engine, 30, 66)}, drawn(engine, -most_gamma, most_gamma)};
}

std::vector<DialReading> readings_at(
    const std::vector<DialGeometry>& dials, const CuboidPose& pose) {
  std::vector<DialReading> readings;
  for (std::size_t i = 0; i < dials.size(); ++i) {
    if (const auto contact = touch(dials[i], pose, kSide_mm)) {
      readings.push_back({static_cast<int>(i), contact->displacement_mm, 0.002});
    }
  }
  return readings;
}

TEST(Contact, TheBallTouchesTheFaceItLooksAt) {
  std::mt19937_64 engine(1);
  const auto dials = default_rig().dial_geometries();
  int touched = 0;
  for (int trial = 0; trial < 2'000; ++trial) {
    const CuboidPose pose = drawn_pose(engine);
    for (const DialGeometry& dial : dials) {
      const auto contact = touch(dial, pose, kSide_mm);
      if (!contact) continue;
      ++touched;
      const Vector2d ball =
          dial.position_mm - (dial.tip_radius_mm + contact->displacement_mm) * dial.axis;
      // Distance of the ball's centre from the square, by its four faces.
      double outside = -1e9;
      for (int face = 0; face < 4; ++face) {
        outside = std::max(
            outside, (ball - pose.p_WE).dot(face_normal(face, pose.gamma_rad)) - kSide_mm / 2);
      }
      ASSERT_LT(std::abs(outside - dial.tip_radius_mm), 1e-12 * 100);
    }
  }
  EXPECT_GT(touched, 8'000);
}

TEST(Contact, JacobianAgreesWithDifferences) {
  std::mt19937_64 engine(2);
  const auto dials = default_rig().dial_geometries();
  for (int trial = 0; trial < 500; ++trial) {
    const CuboidPose pose = drawn_pose(engine);
    for (const DialGeometry& dial : dials) {
      const int face = face_towards(dial, pose.gamma_rad);
      const auto at = [&](const Vector3d& d) {
        return contact_on_face(
                   dial, {pose.p_WE + d.head<2>(), pose.gamma_rad + d[2]}, kSide_mm, face)
            .displacement_mm;
      };
      const Contact contact = contact_on_face(dial, pose, kSide_mm, face);
      Eigen::RowVector3d slope;
      for (int i = 0; i < 3; ++i) {
        const Vector3d h = Vector3d::Unit(i) * 1e-4;
        slope[i] = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / 12e-4;
      }
      ASSERT_LT((contact.J - slope).norm(), 1e-7 * contact.J.norm());
    }
  }
}

TEST(Contact, SaysWhyThereIsNone) {
  const Rig rig = default_rig();
  const DialGeometry& right = rig.dials[0].geometry;
  const auto trouble = [&](const CuboidPose& pose) {
    return touch(right, pose, kSide_mm).error();
  };
  EXPECT_EQ(trouble({{10, 48}, 0}), ContactTrouble::kNoTouch);
  EXPECT_EQ(trouble({{70, 48}, 0}), ContactTrouble::kBeyondTravel);
  EXPECT_EQ(trouble({{28, 100}, 0}), ContactTrouble::kOffFace);
  for (const auto each :
       {ContactTrouble::kNoTouch, ContactTrouble::kBeyondTravel, ContactTrouble::kOffFace,
        ContactTrouble::kAlongFace}) {
    EXPECT_FALSE(describe(each).empty());
  }
}

TEST(Equation39, EqualsTheGeneralFormWithASharpTip) {
  std::mt19937_64 engine(3);
  Rig rig = default_rig();
  for (Dial& dial : rig.dials) dial.geometry.tip_radius_mm = 0.0;
  const auto dials = rig.dial_geometries();
  int compared = 0;
  for (int trial = 0; trial < 5'000; ++trial) {
    const CuboidPose pose = drawn_pose(engine);
    const auto b = touch(dials[1], pose, kSide_mm);
    const auto c = touch(dials[2], pose, kSide_mm);
    const auto d = touch(dials[3], pose, kSide_mm);
    if (!b || !c || !d) continue;
    ++compared;
    const CuboidPose published = equation_39(
        dials[1].position_mm, dials[2].position_mm, dials[3].position_mm, b->displacement_mm,
        c->displacement_mm, d->displacement_mm, kSide_mm);
    const auto general = active_three(
        dials,
        {DialReading{2, c->displacement_mm}, DialReading{3, d->displacement_mm},
         DialReading{1, b->displacement_mm}},
        kSide_mm);
    ASSERT_TRUE(general);
    // 1e-12 mm is 35 ulp of these numbers: both forms solve the same two lines.
    ASSERT_LT((published.p_WE - general->pose.p_WE).norm(), kSharp_mm);
    ASSERT_LT(std::abs(published.gamma_rad - general->pose.gamma_rad), 1e-14 * 10);
    ASSERT_LT((published.p_WE - pose.p_WE).norm(), kSolved_mm);
  }
  EXPECT_GT(compared, 2'000);
}

TEST(Equation39, WithABallIsOffByTheBallsLift) {
  // A ball of radius rho on a face turned by gamma touches rho (1/cos gamma - 1) early, on both
  // faces: (39) puts the face that much too near along its dial's axis.
  const auto dials = default_rig().dial_geometries();
  for (const double gamma : {-0.35, -0.2, 0.1, 0.35}) {
    const CuboidPose pose{{28, 48}, gamma};
    const double b = touch(dials[1], pose, kSide_mm)->displacement_mm;
    const double c = touch(dials[2], pose, kSide_mm)->displacement_mm;
    const double d = touch(dials[3], pose, kSide_mm)->displacement_mm;
    const CuboidPose published = equation_39(
        dials[1].position_mm, dials[2].position_mm, dials[3].position_mm, b, c, d, kSide_mm);
    const double lift = 1.5 * (1 / std::cos(gamma) - 1);
    // In the direction of each face's normal the shift is lift * cos gamma.
    const Vector2d predicted =
        -lift * std::cos(gamma) * (face_normal(0, gamma) + face_normal(1, gamma));
    EXPECT_LT((published.p_WE - pose.p_WE - predicted).norm(), kSolved_mm) << gamma;
  }
}

TEST(ActiveThree, EveryValidChoiceGivesThePoseBack) {
  std::mt19937_64 engine(4);
  const auto dials = default_rig().dial_geometries();
  int solved = 0;
  for (int trial = 0; trial < 1'000; ++trial) {
    const CuboidPose pose = drawn_pose(engine);
    const auto readings = readings_at(dials, pose);
    for (const auto& first : readings) {
      for (const auto& second : readings) {
        for (const auto& single : readings) {
          if (first.dial == second.dial) continue;
          const auto estimate =
              active_three(dials, {first, second, single}, kSide_mm, pose.gamma_rad);
          if (!estimate) continue;
          ++solved;
          ASSERT_LT((estimate->pose.p_WE - pose.p_WE).norm(), kSolved_mm);
          ASSERT_LT(std::abs(estimate->pose.gamma_rad - pose.gamma_rad), 1e-12);
        }
      }
    }
  }
  EXPECT_GT(solved, 5'000);
}

TEST(ActiveThree, WorksWithUnequalBallsAndLeaningDialsAndAnyHold) {
  std::mt19937_64 engine(5);
  Rig rig = default_rig();
  for (Dial& dial : rig.dials) {
    dial.geometry.tip_radius_mm = drawn(engine, 0, 3);
    dial.geometry.axis = Eigen::Rotation2Dd(drawn(engine, -0.1, 0.1)) * dial.geometry.axis;
  }
  const auto dials = rig.dial_geometries();
  int solved = 0;
  for (int trial = 0; trial < 2'000; ++trial) {
    CuboidPose pose = drawn_pose(engine);
    pose.gamma_rad += (trial % 4) * M_PI / 2;  // a square held any way round
    const auto estimate =
        best_active_three(dials, readings_at(dials, pose), kSide_mm, pose.gamma_rad + 0.1);
    if (!estimate) continue;
    ++solved;
    ASSERT_LT((estimate->pose.p_WE - pose.p_WE).norm(), kSolved_mm);
    ASSERT_LT(std::abs(estimate->pose.gamma_rad - pose.gamma_rad), 1e-12);
  }
  EXPECT_GT(solved, 1'500);
}

TEST(ActiveThree, TooFewContactsAreSaid) {
  const auto dials = default_rig().dial_geometries();
  const std::vector<DialReading> one_face{{2, 16, 0.002}, {3, 16, 0.002}};
  EXPECT_EQ(best_active_three(dials, one_face, kSide_mm).error(), PoseTrouble::kTooFewContacts);
  EXPECT_EQ(
      least_squares_pose(dials, one_face, kSide_mm).error(), PoseTrouble::kTooFewContacts);
  EXPECT_EQ(
      least_squares_pose_with_gamma(dials, one_face, kSide_mm, 0.0, 0.01).error(),
      PoseTrouble::kTooFewContacts);
  const std::vector<DialReading> opposite{{0, 16, 0.002}, {1, 16, 0.002}};
  EXPECT_FALSE(best_active_three(dials, opposite, kSide_mm));
  EXPECT_FALSE(best_active_three(dials, {}, kSide_mm));
}

/// Spread of estimates under noise against the covariance they carry.
template <typename Estimator>
void expect_honest_covariance(Estimator&& estimator) {
  std::mt19937_64 engine(6);
  std::normal_distribution<double> noise(0.0, 0.002);
  const auto dials = default_rig().dial_geometries();
  const CuboidPose pose{{25, 50}, 0.15};
  const auto exact = readings_at(dials, pose);
  ASSERT_EQ(exact.size(), 6U);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d said = Eigen::Matrix3d::Zero();
  constexpr int kRepeats = 4'000;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    auto readings = exact;
    for (auto& reading : readings) reading.displacement_mm += noise(engine);
    const auto estimate = estimator(dials, readings);
    ASSERT_TRUE(estimate);
    const Vector3d error(
        estimate->pose.p_WE.x() - pose.p_WE.x(), estimate->pose.p_WE.y() - pose.p_WE.y(),
        estimate->pose.gamma_rad - pose.gamma_rad);
    spread += error * error.transpose() / kRepeats;
    said = estimate->covariance;
  }
  constexpr double kVarianceRelative = 0.10;  // 4.5 sigma of a variance from 4,000 repeats
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(spread(i, i) - said(i, i)), kVarianceRelative * said(i, i)) << i;
  }
}

TEST(ActiveThree, CarriesItsCovariance) {
  expect_honest_covariance([](const auto& dials, const auto& readings) {
    return active_three(dials, {readings[2], readings[3], readings[1]}, kSide_mm);
  });
}

TEST(LeastSquaresPose, CarriesItsCovariance) {
  expect_honest_covariance([](const auto& dials, const auto& readings) {
    return least_squares_pose(dials, readings, kSide_mm);
  });
}

TEST(LeastSquaresPose, IsBetterThanTheBestThree) {
  const auto dials = default_rig().dial_geometries();
  const auto readings = readings_at(dials, {{25, 50}, 0.15});
  const double three =
      best_active_three(dials, readings, kSide_mm)->covariance.topLeftCorner<2, 2>().trace();
  const double all =
      least_squares_pose(dials, readings, kSide_mm)->covariance.topLeftCorner<2, 2>().trace();
  EXPECT_LT(all, three);
  const double held = least_squares_pose_with_gamma(dials, readings, kSide_mm, 0.15, 1e-6)
                          ->covariance.topLeftCorner<2, 2>()
                          .trace();
  EXPECT_LT(held, all);
}

TEST(LeastSquaresPose, ASurplusDialShowsAFaultAsAResidual) {
  const auto dials = default_rig().dial_geometries();
  auto readings = readings_at(dials, {{25, 50}, 0.15});
  readings[0].displacement_mm += 0.1;
  const auto estimate = least_squares_pose(dials, readings, kSide_mm);
  ASSERT_TRUE(estimate);
  double largest = 0;
  for (const double r : estimate->residual_mm) largest = std::max(largest, std::abs(r));
  EXPECT_GT(largest, 0.01);
  const auto with_gamma = least_squares_pose_with_gamma(dials, readings, kSide_mm, 0.15, 1e-9);
  EXPECT_GT(std::abs(with_gamma->residual_mm[0]), 0.04);
}

TEST(LeastSquaresPoseWithGamma, NeedsOnlyTwoNeighbouringFaces) {
  const auto dials = default_rig().dial_geometries();
  const CuboidPose pose{{25, 50}, 0.15};
  const auto all = readings_at(dials, pose);
  const std::vector<DialReading> two{all[1], all[2]};
  const auto estimate =
      least_squares_pose_with_gamma(dials, two, kSide_mm, pose.gamma_rad, 1e-3);
  ASSERT_TRUE(estimate);
  EXPECT_LT((estimate->pose.p_WE - pose.p_WE).norm(), kSolved_mm);
  // Its uncertainty is mostly the clamp's: 1 mrad at the lever of the touching points.
  EXPECT_GT((estimate->covariance.topLeftCorner<2, 2>().trace()), 1e-6);
}

TEST(Rig, CuboidAngleIsZeroAtTheReferencePose) {
  for (const Mount mount : {Mount::kDistal1, Mount::kDistal2, Mount::kFree}) {
    Rig rig = default_rig();
    rig.cuboid.mount = mount;
    const double reference = reference_link_angle(rig).value();
    const auto q = inverse(rig.robot.nominal, rig.cuboid.reference_pose_mm, {});
    const auto pose = forward(rig.robot.nominal, *q, Assembly::kLeft);
    EXPECT_LT(std::abs(cuboid_angle(rig, reference, *pose, 0.0)), 1e-14);
    EXPECT_LT(std::abs(cuboid_angle(rig, reference, *pose, 0.02) - 0.02), 1e-14);
  }
}

}  // namespace
}  // namespace sixdial::geometry
