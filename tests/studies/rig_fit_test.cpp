// The rig as the readings see it: dials that do not stand where the file says are found, as far
// as readings can tell, and what is left open is as large as is said, also where the robot has
// something smooth that nobody named.
#include "diagnosis/rig_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "session/trials.h"
#include "simulation/moved_rig.h"
#include "tests/support/simulated.h"

namespace sixdial::diagnosis {
namespace {

using Eigen::VectorXd;

/// What a workshop knows; `accuracy_mm`: of the dials' curves.
geometry::Rig stating(double accuracy_mm) {
  geometry::Rig rig = geometry::default_rig();
  for (geometry::Dial& dial : rig.dials) {
    dial.accuracy_mm = accuracy_mm;
    dial.deviations.position_mm = Eigen::Vector2d(0.03, 0.1);
    dial.deviations.axis_rad = 2e-3;
  }
  return rig;
}

VectorXd drawn(const geometry::Rig& file, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  VectorXd off(std::ssize(simulation::stated_quantities(file)));
  for (double& each : off) each = normal(engine);
  return off;
}

/// 60 poses, read by dials that are off by so much.
session::Session measured(
    const geometry::Rig& file, const VectorXd& off, mock_devices::World world) {
  world.rig = simulation::moved_rig(file, simulation::stated_quantities(file), off);
  const auto plan = mock_devices::random_plan(file, world.seed, 60, 0);
  return session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(world, plan), file, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(file), "rig.toml");
}

struct Missed {
  double chi_square = 0.0;
  int count = 0;
  double found = 0.0, unfound = 0.0;  // squares of what was missed, and of what there was
  [[nodiscard]] double mean() const { return chi_square / count; }
};

template <class Change>
Missed missed(double accuracy_mm, int sessions, Change&& change) {
  Missed result;
  const geometry::Rig file = stating(accuracy_mm);
  for (int i = 1; i <= sessions; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const VectorXd truth = drawn(file, seed);
    mock_devices::World world = testing::simple_world(seed);
    world.robot = mock_devices::drawn_robot(file, seed);
    change(world);
    const session::Session session = measured(file, truth, world);
    const auto seen = fit_rig(session::trials_of(session, "G1"), session.rig);
    EXPECT_TRUE(seen) << seed;
    if (!seen) continue;
    const VectorXd off = seen->off - truth;
    result.chi_square += off.dot(seen->covariance.ldlt().solve(off));
    result.count += static_cast<int>(off.size());
    result.found += off.squaredNorm();
    result.unfound += truth.squaredNorm();
    // The readings take uncertainty away and add none.
    EXPECT_LE(seen->covariance.diagonal().maxCoeff(), 1.0 + 1e-9) << seed;
  }
  return result;
}

TEST(RigFit, IsOffByAsMuchAsItSays) {
  const Missed of = missed(0.0, 20, [](mock_devices::World&) {});
  EXPECT_NEAR(of.mean(), 1.0, 5.0 * std::sqrt(2.0 / of.count));  // chi-square of 360
  EXPECT_LT(of.found, 0.5 * of.unfound) << "the readings say nothing of the rig";
}

TEST(RigFit, IsNotMisledByWhatIsSmooth) {
  // Curves of the dials, a smooth error of the robot, and the gears: chi-square of 360, and
  // what is known of such things is rough.
  constexpr double kRough = 1.5;
  const Missed of = missed(0.006, 20, [](mock_devices::World& world) {
    world.dials.curve_mm = 0.004;
    world.warp.amplitude_mm = 0.02;
    world.effects.push_back(
        mock_devices::make_effect(world.rig, "joint_eccentricity", "joint1", 4e-4, world.seed));
  });
  std::printf("mean chi-square beside smooth errors %.2f\n", of.mean());
  EXPECT_LT(of.mean(), kRough);
}

TEST(RigFit, IsNoneWhereNothingIsStatedOrTooLittleIsRead) {
  const geometry::Rig silent = geometry::default_rig();
  const session::Session session = measured(silent, VectorXd(0), testing::simple_world(3));
  const auto trials = session::trials_of(session, "G1");
  EXPECT_FALSE(fit_rig(trials, silent));
  EXPECT_TRUE(fit_rig(trials, stating(0.0)));
  EXPECT_FALSE(fit_rig(std::span(trials).first(2), stating(0.0)));
}

TEST(RigFit, AFewGrossReadingsDoNotMoveADial) {
  const geometry::Rig file = stating(0.0);
  const session::Session session = measured(file, drawn(file, 4), testing::simple_world(4));
  auto trials = session::trials_of(session, "G1");
  const auto before = fit_rig(trials, session.rig);
  for (const std::size_t i : {5U, 20U, 41U}) {
    auto& reading = trials[i].reading[i % 6];
    if (reading) *reading += 0.5;
  }
  const auto after = fit_rig(trials, session.rig);
  ASSERT_TRUE(before && after);
  constexpr double kLittle = 0.3;  // standard deviations
  EXPECT_LT((after->off - before->off).cwiseAbs().maxCoeff(), kLittle);
  // What is known is not less certain for it.
  EXPECT_LT(
      (after->covariance.diagonal() - before->covariance.diagonal()).cwiseAbs().maxCoeff(),
      0.1);
}

}  // namespace
}  // namespace sixdial::diagnosis
