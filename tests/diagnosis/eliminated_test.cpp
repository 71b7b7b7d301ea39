// Equations with the random columns eliminated are those of the whole problem.
#include "diagnosis/eliminated.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "calibration/random.h"
#include "diagnosis/orthonormal.h"

namespace sixdial::diagnosis {
namespace {

// Relative, of sums of some hundred products in double precision.
constexpr double kRounding = 1e-9;

struct Problem {
  Eigen::MatrixXd A, C;
  Eigen::VectorXd e, root, u;
  /// All rows and columns, the priors' below.
  [[nodiscard]] Eigen::MatrixXd whole() const {
    Eigen::MatrixXd W = Eigen::MatrixXd::Zero(A.rows() + C.cols(), A.cols() + C.cols());
    W.topLeftCorner(A.rows(), A.cols()) = A;
    W.topRightCorner(C.rows(), C.cols()) = C;
    W.bottomRightCorner(C.cols(), C.cols()) = root.asDiagonal();
    return W;
  }
  [[nodiscard]] Eigen::VectorXd right() const {
    Eigen::VectorXd b(e.size() + u.size());
    b << e, -root.cwiseProduct(u);
    return b;
  }
};

Problem drawn(std::uint32_t stream) {
  calibration::RandomSequence random(11, stream);
  const auto matrix = [&](Eigen::Index rows, Eigen::Index cols, double size) {
    return Eigen::MatrixXd(
        Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return random.uniform(-size, size); }));
  };
  Problem result{matrix(60, 5, 1.0), matrix(60, 12, 3.0), matrix(60, 1, 1.0), {}, {}};
  result.A.col(2) *= 1e-4;  // radians beside millimetres
  result.root = matrix(12, 1, 1.0).cwiseAbs().array() + 0.1;
  result.u = matrix(12, 1, 1.0);
  return result;
}

TEST(Eliminated, HasTheStepTheCovarianceAndTheDeterminantOfTheWhole) {
  for (std::uint32_t stream = 0; stream < 20; ++stream) {
    const Problem problem = drawn(stream);
    const EliminatedEquations equations(
        problem.A, problem.C, problem.e, problem.root, problem.u);
    const Eigen::MatrixXd W = problem.whole();
    const Eigen::MatrixXd inverse = (W.transpose() * W).inverse();
    const Eigen::VectorXd step = inverse * (W.transpose() * problem.right());
    EXPECT_EQ(equations.determined(), 5);
    EXPECT_LE((equations.step(0.0) - step).norm(), kRounding * step.norm());
    EXPECT_NEAR(equations.fall(), step.dot(W.transpose() * problem.right()), 1e-8);
    const Eigen::MatrixXd of_x = inverse.topLeftCorner(5, 5);
    EXPECT_LE((equations.covariance() - of_x).norm(), kRounding * of_x.norm());
    const Eigen::VectorXd of_u = inverse.diagonal().tail(12);
    EXPECT_LE((equations.variance_of_u() - of_u).norm(), kRounding * of_u.norm());
    const Eigen::MatrixXd corner = inverse.bottomRightCorner(12, 12);
    EXPECT_NEAR(equations.log_volume_of_u(), std::log(corner.determinant()), 1e-8);
  }
}

TEST(Eliminated, LeavesOutWhatTheDataDoNotDetermine) {
  Problem problem = drawn(3);
  problem.A.col(4) = problem.A.col(0) - 2.0 * problem.A.col(1);
  const EliminatedEquations equations(problem.A, problem.C, problem.e, problem.root, problem.u);
  EXPECT_EQ(equations.determined(), 4);
  EXPECT_TRUE(equations.step(0.0).allFinite());
}

TEST(Eliminated, WithoutRandomColumnsIsLeastSquares) {
  const Problem problem = drawn(4);
  const EliminatedEquations equations(
      problem.A, Eigen::MatrixXd(60, 0), problem.e, Eigen::VectorXd(), Eigen::VectorXd());
  const Eigen::VectorXd step = problem.A.colPivHouseholderQr().solve(problem.e);
  EXPECT_LE((equations.step(0.0) - step).norm(), kRounding * step.norm());
  EXPECT_EQ(equations.log_volume_of_u(), 0.0);
}

TEST(OrthonormalBasis, WithPriorsSpansTheColumnsOfTheWhole) {
  for (std::uint32_t stream = 0; stream < 20; ++stream) {
    const Problem problem = drawn(stream);
    const Eigen::MatrixXd Q = orthonormal_basis(problem.A, problem.C, problem.root);
    const Eigen::MatrixXd W = problem.whole();
    ASSERT_EQ(Q.cols(), W.cols());
    EXPECT_LE((Q.transpose() * Q - Eigen::MatrixXd::Identity(17, 17)).norm(), kRounding);
    EXPECT_LE((W - Q * (Q.transpose() * W)).norm(), kRounding * W.norm());
  }
}

}  // namespace
}  // namespace sixdial::diagnosis
