// The least-squares core: laws first, then Ceres as the judge of the minimum.
#include "calibration/least_squares.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "calibration/identifiability.h"
#include "calibration/random.h"
#include "calibration/space_fit.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::ParameterVector;

constexpr double kSolved = 1e-10;  // double precision, well conditioned
constexpr double kSameRmse_mm =
    1e-10;  // Ceres and we at one minimum: both converge to rounding
constexpr double kSameParameter_mm = 1e-6;  // along the weakest direction, condition 400

struct Linear {
  MatrixXd A;
  VectorXd b;
  [[nodiscard]] LeastSquaresProblem problem() const {
    return {
        static_cast<int>(A.cols()), static_cast<int>(A.rows()),
        [this](const VectorXd& x, VectorXd& r, MatrixXd* J) {
          r = A * x - b;
          if (J != nullptr) *J = A;
          return true;
        }};
  }
};

Linear random_linear(int rows, int columns, std::uint64_t seed) {
  RandomSequence random(seed);
  Linear result{MatrixXd(rows, columns), VectorXd(rows)};
  for (double& a : result.A.reshaped()) a = random.normal();
  for (double& b : result.b) b = random.normal();
  return result;
}

/// The same cost for Ceres, with our derivative.
class PositionCost : public ceres::SizedCostFunction<2, 10> {
 public:
  PositionCost(Eigen::Vector2d q, Eigen::Vector2d p, geometry::Assembly assembly)
      : q_(std::move(q)), p_(std::move(p)), assembly_(assembly) {}
  bool Evaluate(double const* const* x, double* residual, double** jacobian) const override {
    const ParameterVector v = Eigen::Map<const ParameterVector>(x[0]);
    const auto d = geometry::forward_derivative(v, q_, assembly_);
    if (!d) return false;
    Eigen::Map<Eigen::Vector2d>(residual, 2) = d->pose.p_WE - p_;
    if (jacobian != nullptr && jacobian[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 10, Eigen::RowMajor>> J(jacobian[0]);
      J = d->J_v;
    }
    return true;
  }

 private:
  Eigen::Vector2d q_, p_;
  geometry::Assembly assembly_;
};

ParameterVector by_ceres(const PositionObservations& observations, ParameterVector v) {
  ceres::Problem problem;
  for (int i = 0; i < observations.size(); ++i) {
    problem.AddResidualBlock(
        new PositionCost(
            observations.q_rad.col(i), observations.p_WE.col(i),
            observations.assembly[static_cast<std::size_t>(i)]),
        nullptr, v.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-16;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return v;
}

TEST(LeastSquares, SolvesALinearProblemAsQrDoes) {
  const Linear linear = random_linear(40, 7, 1);
  const auto fit = solve_least_squares(linear.problem(), VectorXd::Zero(7));
  EXPECT_EQ(fit.status, FitStatus::kConverged);
  const VectorXd expected = linear.A.householderQr().solve(linear.b);
  EXPECT_LT((fit.x - expected).norm(), kSolved);
  const MatrixXd covariance = (linear.A.transpose() * linear.A).inverse();
  EXPECT_LT((fit.unit_covariance() - covariance).norm(), kSolved);
  EXPECT_EQ(fit.degrees_of_freedom(), 33);
}

TEST(LeastSquares, KeepsFixedParameters) {
  const Linear linear = random_linear(30, 5, 2);
  LeastSquaresSettings settings;
  settings.fixed = {0, 1, 0, 1, 0};
  VectorXd start = VectorXd::Zero(5);
  start[1] = 0.25;
  start[3] = -2.0;
  const auto fit = solve_least_squares(linear.problem(), start, settings);
  EXPECT_EQ(fit.x[1], 0.25);
  EXPECT_EQ(fit.x[3], -2.0);
  EXPECT_EQ(fit.free, 3);
  // at the minimum of the others
  const VectorXd gradient = fit.J.transpose() * fit.residual;
  for (const int i : {0, 2, 4}) EXPECT_LT(std::abs(gradient[i]), kSolved);
}

TEST(LeastSquares, HoldsADirectionThatTheDataCannotTellWhateverTheStart) {
  Linear linear = random_linear(30, 4, 3);
  linear.A.col(3) = linear.A.col(1);  // only x1 + x3 matters
  LeastSquaresSettings settings;
  settings.scale = VectorXd::Ones(4);
  settings.anchor = VectorXd::Zero(4);
  settings.anchor[1] = 1.0;
  VectorXd first;
  for (const double start : {0.0, 5.0, -300.0}) {
    const auto fit =
        solve_least_squares(linear.problem(), VectorXd::Constant(4, start), settings);
    EXPECT_EQ(fit.held, 1);
    // minimum norm from the anchor: both move by the same amount
    EXPECT_LT(std::abs((fit.x[1] - 1.0) - fit.x[3]), 1e-9);
    if (first.size() == 0) first = fit.x;
    EXPECT_LT((fit.x - first).norm(), 1e-9);
  }
}

TEST(LeastSquares, RobustLossForgetsAGrossError) {
  // a constant, measured 21 times, one of them wrong by 100
  LeastSquaresProblem problem;
  problem.parameters = 1;
  problem.residuals = 21;
  VectorXd y(21);
  for (int i = 0; i < 21; ++i) y[i] = 3.0 + 0.01 * (i - 10);
  y[4] += 100.0;
  problem.evaluate = [&y](const VectorXd& x, VectorXd& r, MatrixXd* J) {
    r = VectorXd::Constant(21, x[0]) - y;
    if (J != nullptr) J->setOnes();
    return true;
  };
  const auto plain = solve_least_squares(problem, VectorXd::Zero(1));
  EXPECT_GT(std::abs(plain.x[0] - 3.0), 4.0);
  for (const Loss loss : {Loss::kHuber, Loss::kCauchy}) {
    LeastSquaresSettings settings;
    settings.loss = loss;
    settings.loss_scale = 0.1;
    const auto fit = solve_least_squares(problem, VectorXd::Constant(1, 4.0), settings);
    EXPECT_LT(std::abs(fit.x[0] - 3.0), 0.02);
    EXPECT_LT(fit.block_weight[4], 0.01);
    EXPECT_GT(fit.block_weight[10], 0.9);
  }
}

TEST(LeastSquares, SaysThatTheStartHasNoValue) {
  LeastSquaresProblem problem{
      1, 1, [](const VectorXd&, VectorXd&, MatrixXd*) { return false; }};
  EXPECT_EQ(solve_least_squares(problem, VectorXd::Zero(1)).status, FitStatus::kBadStart);
}

TEST(LeastSquares, RefusesSizesThatDoNotFit) {
  const Linear linear = random_linear(5, 2, 4);
  EXPECT_THROW(
      (void)solve_least_squares(linear.problem(), VectorXd::Zero(3)), std::invalid_argument);
  LeastSquaresSettings settings;
  settings.block = 2;
  EXPECT_THROW(
      (void)solve_least_squares(linear.problem(), VectorXd::Zero(2), settings),
      std::invalid_argument);
}

TEST(PositionFit, IsAtTheMinimumThatCeresFindsOnTheMeasuredSession) {
  const auto session = testing::measured_session_00();
  ASSERT_EQ(session.g1.size(), 100);
  const auto fit = fit_positions(session.g1, session.nominal);
  EXPECT_EQ(fit.fit.status, FitStatus::kConverged);
  const ParameterVector judge = by_ceres(session.g1, session.nominal);
  EXPECT_LT(std::abs(fit.rmse_mm - position_rmse(session.g1, judge)), kSameRmse_mm);
  EXPECT_LT(
      (fit.v - judge).cwiseQuotient(parameter_scale()).cwiseAbs().maxCoeff(),
      kSameParameter_mm);
}

TEST(PositionFit, IsAtTheMinimumThatCeresFindsInEveryWorkingMode) {
  int tried = 0;
  for (const auto mode : geometry::kWorkingModes) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      testing::SessionPlan plan;
      plan.mode = mode;
      plan.workspace = testing::workspace_of(mode);
      plan.robot = testing::random_robot(plan.nominal, seed);
      plan.non_kinematic = seed % 2 == 0 ? 1.0 : 0.0;
      const auto session = testing::simulate(plan, seed);
      const auto fit = fit_positions(session.g1, session.nominal);
      const ParameterVector judge = by_ceres(session.g1, session.nominal);
      EXPECT_LT(fit.rmse_mm - position_rmse(session.g1, judge), kSameRmse_mm);
      EXPECT_LT(std::abs(fit.rmse_mm - position_rmse(session.g1, judge)), kSameRmse_mm);
      ++tried;
    }
  }
  EXPECT_EQ(tried, 40);
}

}  // namespace
}  // namespace sixdial::calibration
