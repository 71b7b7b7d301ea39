// The filter of equations (17)-(22) and its vectorised forms.
#include "calibration/ekf.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "calibration/five_bar/swarm_kernels.h"
#include "calibration/random.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::ParameterVector;

constexpr double kLinear = 1e-10;      // issue 3: equals recursive least squares to 1e-10
constexpr double kKernel_mm = 1e-11;   // 100 mm at double precision, some hundred flops
constexpr double kKernelState = 1e-7;  // relative, 100 updates of a P that spans six decades

TEST(Ekf, EqualsBatchLeastSquaresOnALinearProblem) {
  RandomSequence random(1);
  const int n = 6;
  MatrixXd information = 0.01 * MatrixXd::Identity(n, n);  // P0 = 100 I
  VectorXd right = VectorXd::Zero(n);
  Ekf filter(VectorXd::Zero(n), 100.0 * MatrixXd::Identity(n, n));
  for (int k = 0; k < 50; ++k) {
    MatrixXd J(2, n);
    for (double& j : J.reshaped()) j = random.normal();
    const Eigen::Vector2d y(random.normal(), random.normal());
    const Eigen::Matrix2d R = Eigen::Vector2d(0.5, 2.0).asDiagonal();
    filter.predict(MatrixXd::Zero(n, n));
    filter.update(y - J * filter.x(), J, R);
    information += J.transpose() * R.inverse() * J;
    right += J.transpose() * R.inverse() * y;
  }
  EXPECT_LT((filter.x() - information.lu().solve(right)).norm(), kLinear);
  EXPECT_LT((filter.P() - information.inverse()).norm(), kLinear);
}

TEST(Ekf, KeepsItsCovarianceSymmetricAndPositiveDefinite) {
  RandomSequence random(2);
  Ekf filter(VectorXd::Zero(4), MatrixXd::Identity(4, 4));
  for (int k = 0; k < 2000; ++k) {
    MatrixXd J(2, 4);
    for (double& j : J.reshaped()) j = 60.0 * random.normal();  // mm/rad
    filter.predict(1e-14 * MatrixXd::Identity(4, 4));
    filter.update(Eigen::Vector2d::Zero(), J, 1e-8 * MatrixXd::Identity(2, 2));
    ASSERT_EQ(filter.P(), filter.P().transpose());
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(filter.P());
    ASSERT_GT(eigen.eigenvalues().minCoeff(), 0.0) << "after update " << k;
  }
}

TEST(Ekf, ProcessNoiseForgetsTheBeginning) {
  Ekf filter(VectorXd::Zero(1), MatrixXd::Identity(1, 1));
  const MatrixXd one = MatrixXd::Identity(1, 1);
  for (int k = 0; k < 200; ++k) {
    filter.predict(0.1 * one);
    const double y = k < 100 ? 0.0 : 1.0;
    filter.update(VectorXd::Constant(1, y) - filter.x(), one, one);
  }
  EXPECT_LT(std::abs(filter.x()[0] - 1.0), 1e-6);
}

TEST(Ekf, AtItsEstimateIsNearTheMinimumWhereTheLinearOneIsNot) {
  testing::SessionPlan plan;
  const auto session = testing::simulate(plan, 3);
  FilterSettings settings;
  const auto extended = filter_positions(session.g1, session.nominal, settings);
  settings.linearisation = Linearisation::kNominal;
  const auto linear = filter_positions(session.g1, session.nominal, settings);
  EXPECT_LT(position_rmse(session.g1, extended.v), 0.06);
  EXPECT_GT(position_rmse(session.g1, linear.v), position_rmse(session.g1, extended.v));
  ASSERT_EQ(extended.history.size(), 100U);
  EXPECT_EQ(ParameterVector(session.nominal + extended.history.back()), extended.v);
  EXPECT_EQ(extended.unreachable, 0);
}

TEST(SwarmKernels, RmseEqualsThePlainFormulaInEveryMode) {
  int tried = 0;
  for (const auto mode : geometry::kWorkingModes) {
    testing::SessionPlan plan;
    plan.mode = mode;
    plan.workspace = testing::workspace_of(mode);
    const auto session = testing::simulate(plan, 5);
    const SwarmTable table(session.g1, session.nominal);
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
      ParameterLanes v;
      for (int lane = 0; lane < kLanes; ++lane) {
        v.col(lane) =
            testing::random_robot(session.nominal, 100 * seed + static_cast<unsigned>(lane));
      }
      Lanes<1> rmse_mm;
      swarm_rmse(table, v, rmse_mm);
      for (int lane = 0; lane < kLanes; ++lane) {
        const double expected = position_rmse(session.g1, v.col(lane));
        if (!std::isfinite(expected)) {
          EXPECT_TRUE(std::isinf(rmse_mm[lane]));
          continue;
        }
        EXPECT_LT(std::abs(rmse_mm[lane] - expected), kKernel_mm);
        ++tried;
      }
    }
  }
  EXPECT_GT(tried, 700);
}

TEST(SwarmKernels, UnreachableAndBrokenParticlesAreInfinitelyBad) {
  const auto session = testing::simulate({}, 5);
  const SwarmTable table(session.g1, session.nominal);
  ParameterLanes v;
  v.colwise() = session.nominal;
  v(geometry::kL12, 0) = v(geometry::kL22, 0) = 20.0;  // links too short to close
  v(geometry::kL11, 1) = -60.0;
  v(geometry::kD, 2) = 300.0;
  v(geometry::kX0, 3) = std::nan("");
  v(geometry::kAlpha, 4) = HUGE_VAL;
  v(geometry::kL21, 5) = std::nan("");
  Lanes<1> rmse_mm;
  swarm_rmse(table, v, rmse_mm);
  for (int lane = 0; lane < 6; ++lane) {
    EXPECT_TRUE(std::isinf(rmse_mm[lane]) && rmse_mm[lane] > 0) << "lane " << lane;
  }
  EXPECT_TRUE(std::isfinite(rmse_mm[6]));
  EXPECT_EQ(rmse_mm[6], rmse_mm[7]);
}

TEST(SwarmKernels, FiltersEqualTheClassInJosephForm) {
  RandomSequence random(6);
  for (const auto mode : geometry::kWorkingModes) {
    testing::SessionPlan plan;
    plan.mode = mode;
    plan.workspace = testing::workspace_of(mode);
    const auto session = testing::simulate(plan, 6);
    const SwarmTable table(session.g1, session.nominal);
    NoiseLanes noise;
    for (double& each : noise.reshaped()) each = std::pow(10.0, random.uniform(-7, -1));
    const ParameterVector p0 = ParameterVector::Ones();
    for (const auto linearisation : {Linearisation::kNominal, Linearisation::kEstimate}) {
      ParameterLanes state;
      if (linearisation == Linearisation::kNominal) {
        swarm_filter_nominal(table, p0, noise, state);
      } else {
        swarm_filter_estimate(table, p0, noise, state);
      }
      for (int lane = 0; lane < kLanes; ++lane) {
        FilterSettings settings;
        settings.linearisation = linearisation;
        settings.noise.q = noise.col(lane).head<10>();
        settings.noise.r = noise.col(lane).tail<2>();
        const auto run = filter_positions(session.g1, session.nominal, settings);
        const ParameterVector expected = run.v - session.nominal;
        if (run.unreachable > 0) {
          EXPECT_FALSE(state.col(lane).allFinite());
          continue;
        }
        EXPECT_LT((state.col(lane) - expected).norm(), kKernelState * (1.0 + expected.norm()))
            << "mode " << geometry::to_string(mode) << " lane " << lane;
      }
    }
  }
}

}  // namespace
}  // namespace sixdial::calibration
