// What no reading shows of a fit's parameters.
#include "diagnosis/normal_inverse.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sixdial::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

JointFit fit_of(const MatrixXd& J) {
  JointFit fit;
  fit.J = J;
  fit.random.resize(J.rows(), 0);
  fit.residual_mm = VectorXd::Zero(J.rows());
  fit.weight = VectorXd::Ones(J.rows());
  fit.noise = VectorXd::Ones(J.rows());
  fit.s_mm = 1.0;
  return fit;
}

TEST(NormalInverse, HasTheDirectionsThatNoReadingShows) {
  MatrixXd J(4, 4);
  J.col(0) << 1.0, 2.0, -1.0, 0.5;
  J.col(1) = 2000.0 * J.col(0);  // another unit, the same effect
  J.col(2).setZero();            // held
  J.col(3) << 0.0, 1.0, 1.0, -1.0;
  const NormalInverse inverse(fit_of(J));
  ASSERT_EQ(inverse.unseen.cols(), 1);
  const VectorXd n = inverse.unseen.col(0);
  EXPECT_GT(n.norm(), 0.0);
  EXPECT_LT(std::abs(n[0] / n[1] + 2000.0), 1e-6);
  EXPECT_EQ(n[2], 0.0);
  EXPECT_LT(std::abs(n[3]), 1e-9 * std::abs(n[0]));
  // The estimate leaves it alone: in units of what each parameter moves, none of its changes
  // has a part along it. Nor does it move what is held.
  const VectorXd moves = J.colwise().norm().transpose();
  const VectorXd along = moves.cwiseProduct(n).normalized();
  const MatrixXd changes = moves.asDiagonal() * inverse.estimate;
  EXPECT_LT((changes.transpose() * along).norm(), 1e-9 * changes.norm());
  EXPECT_GT(changes.norm(), 0.1);
  EXPECT_EQ(inverse.estimate.row(2).norm(), 0.0);
}

TEST(NormalInverse, HasNoneWhereEachIsShown) {
  MatrixXd J(3, 2);
  J << 1.0, 0.0, 0.0, 1e-3, 1.0, 1e-3;
  EXPECT_EQ(NormalInverse(fit_of(J)).unseen.cols(), 0);
}

}  // namespace
}  // namespace sixdial::diagnosis
