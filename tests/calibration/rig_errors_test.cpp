// Dials that do not stand quite where the rig file says put all positions off by one law. What
// a file states of that is in the intervals of a calibration: they hold the truth as often as
// they say, and without it they do not.
#include "calibration/rig_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/random.h"
#include "calibration/uncertainty.h"
#include "geometry/instruments/contact.h"
#include "simulation/rig_quantities.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using testing::DialSession;

using testing::SessionPlan;
using testing::simulate_dials;

constexpr double kAlong_mm = 0.03, kAcross_mm = 0.1, kLean_rad = 2e-3;  // a workshop's

/// The same session on a rig whose true dials are these; the file stays as it was.
void measure_again(
    const std::vector<geometry::DialGeometry>& true_dials, std::uint64_t seed,
    DialSession& session) {
  const double reference = geometry::reference_link_angle(session.rig).value();
  const auto file = session.rig.dial_geometries();
  RandomSequence random(seed, 77);
  for (simulation::Trial& trial : session.g1) {
    const auto pose = geometry::forward(session.robot, trial.q, trial.assembly).value();
    const double gamma =
        geometry::cuboid_angle(session.rig, reference, pose, session.clamp_rad);
    std::vector<geometry::DialReading> readings;
    for (std::size_t k = 0; k < file.size(); ++k) {
      trial.reading[k].reset();
      const auto seen =
          geometry::touch(true_dials[k], {pose.p_WE, gamma}, session.rig.cuboid.side_mm);
      if (!seen) continue;
      const double reading_mm = seen->displacement_mm + 0.002 * random.normal();
      trial.reading[k] = reading_mm;
      readings.push_back({static_cast<int>(k), reading_mm, 0.002});
    }
    trial.position_mm.reset();
    const auto estimate =
        geometry::best_active_three(file, readings, session.rig.cuboid.side_mm, gamma);
    if (!estimate) continue;
    trial.position_mm = estimate->pose.p_WE;
    trial.position_covariance = estimate->covariance.topLeftCorner<2, 2>();
    trial.gamma_rad = estimate->pose.gamma_rad;
    trial.position_channels = estimate->dials;
  }
}

void state_deviations(geometry::Rig& rig) {
  for (geometry::Dial& dial : rig.dials) {
    dial.deviations.position_mm = Eigen::Vector2d(kAlong_mm, kAcross_mm);
    dial.deviations.axis_rad = kLean_rad;
  }
}

TEST(RigErrors, OfAPositionAreHowFarItMovesWhenADialStandsElsewhere) {
  DialSession session = simulate_dials({.g1_points = 30, .noise_mm = 0.0}, 5);
  std::vector<geometry::DialGeometry> dials = session.rig.dial_geometries();
  measure_again(dials, 1, session);
  const auto before = session.g1;
  state_deviations(session.rig);
  const ObservationSpace space = position_space(before, session.rig);
  ASSERT_EQ(space.rig_mm.rows(), space.rows());
  ASSERT_EQ(space.rig_mm.cols(), 3 * std::ssize(dials));
  const auto quantities = simulation::stated_quantities(session.rig);
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    if (quantities[k].name.find("across") == std::string::npos) continue;
    auto moved = dials;
    geometry::DialGeometry& dial = moved[static_cast<std::size_t>(quantities[k].place.dial)];
    constexpr double kShare = 0.1;  // of a standard deviation: what bends stays small
    dial.position_mm +=
        kShare * quantities[k].sd * Eigen::Vector2d(-dial.axis.y(), dial.axis.x());
    measure_again(moved, 1, session);
    for (int i = 0; i < space.samples(); ++i) {
      const auto at = static_cast<std::size_t>(space.sample[static_cast<std::size_t>(i)]);
      if (session.g1[at].position_channels != before[at].position_channels) continue;
      const Eigen::Vector2d shift = *session.g1[at].position_mm - *before[at].position_mm;
      const Eigen::Vector2d told =
          kShare * space.rig_mm.block<2, 1>(2 * i, static_cast<Eigen::Index>(k));
      // Of 2 um at most: second order, and the robot is the nominal one.
      constexpr double kSecondOrder_mm = 2e-4;
      EXPECT_NEAR((shift - told).norm(), 0.0, kSecondOrder_mm) << quantities[k].name << i;
    }
  }
}

TEST(RigErrors, WithThemIntervalsHoldTheTruthAsOftenAsTheySay) {
  int inside = 0, without = 0, of = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    DialSession session = simulate_dials({.g1_points = 60, .noise_mm = 0.002}, seed);
    RandomSequence random(seed, 78);
    auto dials = session.rig.dial_geometries();
    for (geometry::DialGeometry& dial : dials) {
      const Eigen::Vector2d across(-dial.axis.y(), dial.axis.x());
      dial.position_mm += kAlong_mm * random.normal() * dial.axis;
      dial.position_mm += kAcross_mm * random.normal() * across;
      const double lean = kLean_rad * random.normal();
      dial.axis = (dial.axis + lean * across).normalized();
    }
    measure_again(dials, seed, session);
    geometry::Rig stated = session.rig;
    state_deviations(stated);
    const auto count = [&](const geometry::Rig& rig, int& held) {
      const ObservationSpace space = position_space(session.g1, rig, 0.002);
      const LeastSquaresFit fit = solve_least_squares(
          space.problem(Weighting::kByCovariance), space.nominal, core_settings(space, {}));
      const Eigen::MatrixXd covariance =
          fit_covariance(space, fit, Weighting::kByCovariance, std::sqrt(fit.variance()));
      for (Eigen::Index k = 0; k < fit.x.size(); ++k) {
        constexpr double kNormal_95 = 1.96;
        held +=
            std::abs(fit.x[k] - session.robot[k]) <= kNormal_95 * std::sqrt(covariance(k, k))
                ? 1
                : 0;
      }
    };
    count(stated, inside);
    count(session.rig, without);
    of += static_cast<int>(session.robot.size());
  }
  // 60 sessions whose ten parameters hang together: sd of a share of 0.95 is 0.03 at worst.
  EXPECT_GE(inside, 0.90 * of);
  EXPECT_LE(without, 0.60 * of) << "the test shows nothing if the rig does not matter";
}

TEST(RigErrors, AreNoneWhereNothingIsStatedOrAnInstrumentMeasures) {
  DialSession session = simulate_dials({.g1_points = 12}, 3);
  EXPECT_EQ(position_space(session.g1, session.rig).rig_mm.size(), 0);
  EXPECT_EQ(dial_space(session.g1, session.rig).rig_mm.size(), 0);
  state_deviations(session.rig);
  EXPECT_GT(dial_space(session.g1, session.rig).rig_mm.norm(), 0.0);
  for (simulation::Trial& trial : session.g1) trial.position_channels.clear();
  EXPECT_EQ(position_space(session.g1, session.rig).rig_mm.norm(), 0.0);
}

}  // namespace
}  // namespace sixdial::calibration
