// 95 % intervals hold the truth in 95 % of sessions: with noise that differs from pose to pose,
// with something smooth that the model misses, with few points and a rig file that is wrong.
#include "calibration/fit_covariance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/uncertainty.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using testing::DialSession;
using testing::SessionPlan;
using testing::simulate_dials;

constexpr int kSessions = 200;
// Ten parameters of a session are one draw for this purpose at worst: sd of a share of 0.95 in
// 200 sessions is 0.015.
constexpr double kLeastCoverage = 0.92, kMostCoverage = 0.98;

ObservationSpace positions(const DialSession& session) {
  return position_space(position_observations(session.g1), session.rig.robot.nominal);
}

LeastSquaresFit fit_of(const ObservationSpace& space) {
  return solve_least_squares(
      space.problem(Weighting::kAlike), space.nominal, core_settings(space, {}));
}

struct Coverage {
  int inside = 0, of = 0;
  double sum_sd = 0.0;
  [[nodiscard]] double share() const { return static_cast<double>(inside) / of; }
};

void count(
    const std::vector<ParameterEstimate>& estimates, const Eigen::VectorXd& truth,
    Coverage& coverage) {
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    const double value = truth[static_cast<Eigen::Index>(k)];
    coverage.inside += estimates[k].low_95 <= value && value <= estimates[k].high_95 ? 1 : 0;
    coverage.sum_sd += estimates[k].sd;
    ++coverage.of;
  }
}

/// Over many sessions of a plan; `structured` false: as if all that is left were noise.
Coverage coverage_of(const SessionPlan& plan, bool structured) {
  Coverage coverage;
  for (int k = 0; k < kSessions; ++k) {
    const auto session = simulate_dials(plan, static_cast<std::uint64_t>(3000 + k));
    const ObservationSpace space = positions(session);
    const LeastSquaresFit fit = fit_of(space);
    const Structure structure =
        structured ? smooth_structure(space, fit, Weighting::kAlike) : Structure{};
    Eigen::MatrixXd covariance;
    count(
        estimates_with_noise(
            space, fit, Weighting::kAlike, noise_estimate(space, fit), structure, covariance),
        session.robot, coverage);
  }
  return coverage;
}

TEST(FitCovariance, IsThatOfIndependentRowsWhereTheyAreAlike) {
  const auto session = testing::simulate({}, 7);
  const ObservationSpace space = position_space(session.g1, session.nominal);
  const LeastSquaresFit fit = fit_of(space);
  constexpr double kRounding = 1e-9;  // relative
  const Eigen::MatrixXd plain = 4e-6 * fit.unit_covariance();
  const Eigen::MatrixXd C = fit_covariance(space, fit, Weighting::kAlike, 0.002);
  EXPECT_LT((C - plain).norm(), kRounding * plain.norm());
}

TEST(FitCovariance, HoldsTheTruthWherePosesAreMeasuredWithDifferentPrecision) {
  SessionPlan plan;
  plan.g1_points = 40;
  const Coverage coverage = coverage_of(plan, true);
  EXPECT_GE(coverage.share(), kLeastCoverage);
  EXPECT_LE(coverage.share(), kMostCoverage);
}

TEST(FitCovariance, HoldsTheTruthWithFewPointsAndAWrongRigFile) {
  SessionPlan plan;
  plan.g1_points = 9;
  plan.noise_mm = 0.006;
  Coverage coverage;
  for (int k = 0; k < kSessions; ++k) {
    auto session = simulate_dials(plan, static_cast<std::uint64_t>(4000 + k));
    for (simulation::Trial& trial : session.g1) trial.position_covariance /= 9.0;
    const ObservationSpace space = positions(session);
    const LeastSquaresFit fit = fit_of(space);
    if (fit.held > 0) continue;
    Eigen::MatrixXd covariance;
    count(
        estimates_with_noise(
            space, fit, Weighting::kAlike, noise_estimate(space, fit), {}, covariance),
        session.robot, coverage);
  }
  EXPECT_GT(coverage.of, 5 * kSessions);
  EXPECT_GE(coverage.share(), kLeastCoverage);
}

// Gears that are not centred and links that bend leave some 0.03 mm that no parameter explains.
TEST(FitCovariance, HoldsTheTruthWithSomethingSmoothInTheData) {
  SessionPlan plan;
  plan.non_kinematic = 1.0;
  constexpr double kLeastWithStructure = 0.90;  // asked
  constexpr double kWithout = 0.75;  // what leaving it out is worth: the test's power
  const Coverage with = coverage_of(plan, true);
  EXPECT_GE(with.share(), kLeastWithStructure);
  EXPECT_LE(coverage_of(plan, false).share(), kWithout);
}

TEST(Structure, IsSeldomSeenInNoiseAndAlwaysInWhatIsSmooth) {
  int in_noise = 0, in_smooth = 0;
  for (int k = 0; k < kSessions; ++k) {
    SessionPlan plan;
    for (const bool smooth : {false, true}) {
      plan.non_kinematic = smooth ? 1.0 : 0.0;
      const auto session = testing::simulate(plan, static_cast<std::uint64_t>(5000 + k));
      const ObservationSpace space = position_space(session.g1, session.nominal);
      const Structure structure = smooth_structure(space, fit_of(space), Weighting::kAlike);
      (smooth ? in_smooth : in_noise) += structure.sd_mm > 0.0 ? 1 : 0;
    }
  }
  EXPECT_LE(in_noise, kSessions / 5);  // the best of six lengths, each at 5 %
  EXPECT_EQ(in_smooth, kSessions);
}

}  // namespace
}  // namespace sixdial::calibration
