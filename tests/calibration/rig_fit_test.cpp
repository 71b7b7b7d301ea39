// The rig as the readings see it: dials that do not stand where the file says are found, as far
// as readings can tell, and what is left open is as large as is said.
#include "calibration/rig_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "calibration/known_unknowns.h"
#include "calibration/random.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/instruments/contact.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::DialSession;
using testing::simulate_dials;

constexpr double kNoise_mm = 0.002;

void state_deviations(geometry::Rig& rig) {
  for (geometry::Dial& dial : rig.dials) {
    dial.accuracy_mm = 0.0;  // no curves here
    dial.deviations.position_mm = Eigen::Vector2d(0.03, 0.1);
    dial.deviations.axis_rad = 2e-3;
  }
}

/// The same poses read by the dials of another rig.
void read_by(const geometry::Rig& true_rig, std::uint64_t seed, DialSession& session) {
  const double reference = geometry::reference_link_angle(session.rig).value();
  RandomSequence random(seed, 77);
  const auto dials = true_rig.dial_geometries();
  for (simulation::Trial& trial : session.g1) {
    const auto pose = geometry::forward(session.robot, trial.q, trial.assembly).value();
    const double gamma =
        geometry::cuboid_angle(session.rig, reference, pose, session.clamp_rad);
    for (std::size_t k = 0; k < dials.size(); ++k) {
      const auto seen = geometry::touch(dials[k], {pose.p_WE, gamma}, true_rig.cuboid.side_mm);
      trial.reading[k] =
          seen ? std::optional(seen->displacement_mm + kNoise_mm * random.normal())
               : std::nullopt;
    }
  }
}

TEST(RigFit, IsOffByAsMuchAsItSays) {
  double squares = 0.0;
  int count = 0;
  double nearer = 0.0, farther = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    DialSession session = simulate_dials({.g1_points = 60, .noise_mm = kNoise_mm}, seed);
    state_deviations(session.rig);
    RandomSequence random(seed, 78);
    VectorXd truth(std::ssize(simulation::stated_quantities(session.rig)));
    for (double& each : truth) each = random.normal();
    read_by(moved_rig(session.rig, truth), seed, session);
    const auto seen = fit_rig(session.g1, session.rig);
    ASSERT_TRUE(seen);
    ASSERT_EQ(seen->off.size(), truth.size());
    const VectorXd missed = seen->off - truth;
    squares += missed.dot(seen->covariance.ldlt().solve(missed));
    count += static_cast<int>(truth.size());
    nearer += missed.squaredNorm();
    farther += truth.squaredNorm();
    EXPECT_LT(
        (moved_rig(session.rig, seen->off).dials[2].geometry.position_mm -
         seen->rig.dials[2].geometry.position_mm)
            .norm(),
        1e-12);
  }
  // chi-square of 360: within 5 standard deviations.
  EXPECT_NEAR(squares / count, 1.0, 5.0 * std::sqrt(2.0 / count));
  EXPECT_LT(nearer, 0.5 * farther) << "the readings say nothing of the rig";
}

TEST(RigFit, IsNoneWhereNothingIsStatedOrTooLittleIsRead) {
  DialSession session = simulate_dials({.g1_points = 30, .noise_mm = kNoise_mm}, 3);
  EXPECT_FALSE(fit_rig(session.g1, session.rig));
  state_deviations(session.rig);
  EXPECT_TRUE(fit_rig(session.g1, session.rig));
  EXPECT_FALSE(fit_rig(std::span(session.g1).first(2), session.rig));
}

TEST(RigFit, AFewGrossReadingsDoNotMoveADial) {
  DialSession session = simulate_dials({.g1_points = 60, .noise_mm = kNoise_mm}, 4);
  state_deviations(session.rig);
  const auto before = fit_rig(session.g1, session.rig, {}, Loss::kHuber);
  for (const std::size_t i : {5U, 20U, 41U}) {
    auto& reading = session.g1[i].reading[i % 6];
    if (reading) *reading += 0.5;
  }
  const auto after = fit_rig(session.g1, session.rig, {}, Loss::kHuber);
  ASSERT_TRUE(before && after);
  constexpr double kLittle = 0.3;  // standard deviations
  EXPECT_LT((after->off - before->off).cwiseAbs().maxCoeff(), kLittle);
}

TEST(KnownUnknowns, ASpaceWithThemIsASpaceLikeAnyOther) {
  DialSession session = simulate_dials({.g1_points = 30, .noise_mm = kNoise_mm}, 5);
  state_deviations(session.rig);
  const ObservationSpace space = dial_space(session.g1, session.rig);
  const VectorXd known = VectorXd::Constant(space.rig_mm.cols(), 0.5);
  const ObservationSpace all = with_known(space, space.rig_mm, known);
  ASSERT_EQ(all.parameters(), space.parameters() + space.rig_mm.cols());
  ASSERT_EQ(all.samples(), space.samples() + space.rig_mm.cols());
  ASSERT_EQ(all.rows(), space.rows() + space.rig_mm.cols());
  EXPECT_EQ(all.measured_mm.size(), all.rows());
  // Its Jacobian is that of its errors.
  VectorXd x = all.nominal;
  x.tail(space.rig_mm.cols()).setConstant(3e-3);
  for (const int sample : {0, 7, all.samples() - 1}) {
    const Index rows = all.rows(sample);
    VectorXd e(rows), ahead(rows), behind(rows);
    Eigen::MatrixXd J(rows, all.parameters());
    ASSERT_TRUE(all.evaluate(sample, x, e, &J));
    for (int k = 0; k < all.parameters(); ++k) {
      constexpr double kStep = 1e-5;
      VectorXd there = x;
      there[k] += kStep;
      ASSERT_TRUE(all.evaluate(sample, there, ahead, nullptr));
      there[k] -= 2 * kStep;
      ASSERT_TRUE(all.evaluate(sample, there, behind, nullptr));
      const VectorXd slope = (behind - ahead) / (2 * kStep);
      EXPECT_LT((slope - J.col(k)).norm(), 1e-6 * (1.0 + J.col(k).norm())) << k;
    }
  }
  EXPECT_EQ(
      with_known(space, Eigen::MatrixXd(space.rows(), 0)).parameters(), space.parameters());
}

}  // namespace
}  // namespace sixdial::calibration
