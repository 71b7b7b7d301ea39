// The quick way of the least-squares core (normal equations by a vector kernel) against the
// careful one (geometry/robots/five_bar.h, QR, singular values).
#include <gtest/gtest.h>

#include "calibration/five_bar/position_kernel.h"
#include "calibration/space_fit.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::ParameterVector;

constexpr double kSameSums = 1e-11;      // relative: sums of 100 products, poses of 60 mm
constexpr double kSameParameter = 1e-9;  // mm or 1/60 rad; their deviations are some 1e-2
constexpr double kSameRss_mm2 = 1e-12;

struct Sums {
  MatrixXd JtJ = MatrixXd::Zero(10, 10);
  VectorXd Jtr = VectorXd::Zero(10);
  double rss = 0.0;
};

Sums by_reference(const PositionObservations& observations, const ParameterVector& v) {
  VectorXd r(2 * observations.size());
  MatrixXd J(r.size(), 10);
  EXPECT_TRUE(position_problem(observations).evaluate(v, r, &J));
  return {
      MatrixXd((J.transpose() * J).triangularView<Eigen::Lower>()), J.transpose() * r,
      r.squaredNorm()};
}

TEST(NormalEquations, AreThoseOfTheReferenceInEveryWorkingModeAndForAnyNumberOfSamples) {
  int tried = 0;
  for (const auto mode : geometry::kWorkingModes) {
    for (const int points : {1, 7, 8, 9, 100}) {
      testing::SessionPlan plan;
      plan.mode = mode;
      plan.workspace = testing::workspace_of(mode);
      plan.g1_points = points;
      const auto session = testing::simulate(plan, 11);
      const ParameterVector v = testing::random_robot(session.nominal, 12);
      const Sums expected = by_reference(session.g1, v);
      Sums found;
      ASSERT_TRUE(
          position_normal(position_blocks(session.g1), v, found.JtJ, found.Jtr, found.rss));
      const VectorXd size = expected.JtJ.diagonal().cwiseSqrt();
      for (int i = 0; i < 10; ++i) {
        for (int j = 0; j <= i; ++j) {
          EXPECT_LT(
              std::abs(found.JtJ(i, j) - expected.JtJ(i, j)), kSameSums * size[i] * size[j]);
        }
        EXPECT_LT(
            std::abs(found.Jtr[i] - expected.Jtr[i]),
            kSameSums * size[i] * std::sqrt(expected.rss));
      }
      EXPECT_LT(std::abs(found.rss - expected.rss), kSameSums * expected.rss);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 20);
}

TEST(NormalEquations, HaveNoValueWhereOneSampleIsOutOfReach) {
  testing::SessionPlan plan;
  const auto session = testing::simulate(plan, 13);
  ParameterVector v = session.nominal;
  v[geometry::kL12] = v[geometry::kL22] = 20.0;
  Sums sums;
  EXPECT_FALSE(position_normal(position_blocks(session.g1), v, sums.JtJ, sums.Jtr, sums.rss));
  v[geometry::kL12] = std::nan("");
  EXPECT_FALSE(position_normal(position_blocks(session.g1), v, sums.JtJ, sums.Jtr, sums.rss));
}

/// The fit of a problem, and how often the careful way was asked for a Jacobian.
struct Counted {
  LeastSquaresFit fit;
  int jacobians = 0;
  int normals = 0;
};

Counted solve(
    LeastSquaresProblem problem, const ParameterVector& nominal, bool quick,
    const std::vector<char>& fixed = {}) {
  Counted result;
  LeastSquaresProblem counted = problem;
  counted.evaluate = [&](const VectorXd& x, VectorXd& r, MatrixXd* J) {
    if (J != nullptr) ++result.jacobians;
    return problem.evaluate(x, r, J);
  };
  counted.normal = nullptr;
  if (quick) {
    counted.normal = [&](const VectorXd& x, MatrixXd& JtJ, VectorXd& Jtr, double& rss) {
      ++result.normals;
      return problem.normal(x, JtJ, Jtr, rss);
    };
  }
  LeastSquaresSettings settings;
  settings.first_damping = 1e-7;
  settings.scale = parameter_scale();
  settings.anchor = nominal;
  settings.fixed = fixed;
  settings.hold_below = 0.003 / 2.0;
  result.fit = solve_least_squares(counted, nominal, settings);
  return result;
}

void expect_same(const Counted& quick, const Counted& careful) {
  EXPECT_EQ(quick.fit.status, FitStatus::kConverged);
  EXPECT_EQ(quick.fit.status, careful.fit.status);
  EXPECT_EQ(quick.fit.held, careful.fit.held);
  EXPECT_LT(std::abs(quick.fit.rss - careful.fit.rss), kSameRss_mm2);
  const VectorXd apart = (quick.fit.x - careful.fit.x).cwiseQuotient(parameter_scale());
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), kSameParameter);
  EXPECT_LT(
      (quick.fit.singular_values - careful.fit.singular_values).cwiseAbs().maxCoeff(),
      kSameParameter * careful.fit.singular_values[0]);
}

TEST(NormalEquations, LeadToTheSameMinimumWithOneJacobian) {
  int tried = 0;
  for (const auto mode : geometry::kWorkingModes) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      testing::SessionPlan plan;
      plan.mode = mode;
      plan.workspace = testing::workspace_of(mode);
      plan.robot = testing::random_robot(plan.nominal, seed);
      plan.non_kinematic = seed % 2 == 0 ? 1.0 : 0.0;
      const auto session = testing::simulate(plan, seed);
      const LeastSquaresProblem problem = position_problem(session.g1);
      std::vector<char> fixed(10, 0);
      fixed[geometry::kD] = seed % 3 == 0 ? 1 : 0;
      const Counted quick = solve(problem, session.nominal, true, fixed);
      const Counted careful = solve(problem, session.nominal, false, fixed);
      EXPECT_EQ(careful.normals, 0);
      if (careful.fit.held > 0) continue;
      expect_same(quick, careful);
      EXPECT_EQ(quick.jacobians, 1) << geometry::to_string(mode) << " seed " << seed;
      EXPECT_LE(quick.normals, 10);
      ++tried;
    }
  }
  EXPECT_GT(tried, 20);
}

TEST(NormalEquations, LeaveTheFitToTheCarefulWayWhereADirectionIsNotDetermined) {
  // A corner of the workspace: too few directions for ten parameters.
  testing::SessionPlan plan;
  plan.g1_points = 6;
  plan.workspace = {20, 24, 40, 44};
  const auto session = testing::simulate(plan, 21);
  const LeastSquaresProblem problem = position_problem(session.g1);
  const Counted quick = solve(problem, session.nominal, true);
  const Counted careful = solve(problem, session.nominal, false);
  EXPECT_GT(careful.fit.held, 0);
  EXPECT_GT(quick.normals, 0);
  EXPECT_EQ(quick.jacobians, careful.jacobians);
  EXPECT_EQ(quick.fit.x, careful.fit.x);
}

TEST(NormalEquations, FindTheExactRobotOfExactData) {
  testing::SessionPlan plan;
  plan.noise_mm = 0.0;
  const auto session = testing::simulate(plan, 22);
  const Counted quick = solve(position_problem(session.g1), session.nominal, true);
  EXPECT_EQ(quick.fit.status, FitStatus::kConverged);
  EXPECT_LT(
      (quick.fit.x - session.robot).cwiseQuotient(parameter_scale()).cwiseAbs().maxCoeff(),
      kSameParameter);
}

}  // namespace
}  // namespace sixdial::calibration
