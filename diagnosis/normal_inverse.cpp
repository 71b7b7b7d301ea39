#include "diagnosis/normal_inverse.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>

#include "diagnosis/eliminated.h"

namespace sixdial::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

NormalInverse::NormalInverse(const JointFit& fit) {
  const Whitening whitening = fit.whitening();
  const Index p = fit.J.cols();
  const Index m = fit.random.cols();
  rows.resize(fit.J.rows(), p + m);
  rows.leftCols(p) = whitening(fit.J);
  rows.rightCols(m) = whitening(fit.scaled_random());
  // Scaled: millimetres stand beside radians. The prior of each u is a row with a one.
  VectorXd squares = rows.colwise().squaredNorm();
  squares.tail(m).array() += 1.0;
  const VectorXd scale =
      squares.unaryExpr([](double each) { return each > 0 ? 1.0 / std::sqrt(each) : 0.0; });
  rows *= scale.asDiagonal();
  MatrixXd normal = gram(rows);
  normal.diagonal().tail(m) += scale.tail(m).cwiseAbs2();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(normal);
  constexpr double kUnseen = 1e-13;  // of the largest: rounding
  const double least = kUnseen * eigen.eigenvalues().maxCoeff();
  const VectorXd inverse = eigen.eigenvalues().unaryExpr(
      [least](double each) { return each > least ? 1.0 / each : 0.0; });
  const MatrixXd& V = eigen.eigenvectors();
  // They come first, in ascending order. A parameter without a slope may be mixed into any of
  // them: less it, they have length one or none.
  MatrixXd first = V.topLeftCorner(p, (eigen.eigenvalues().array() <= least).count());
  for (Index i = 0; i < p; ++i) {
    if (scale[i] == 0.0) first.row(i).setZero();
  }
  unseen.resize(p, 0);
  if (first.cols() > 0) {
    const Eigen::JacobiSVD<MatrixXd> svd(first, Eigen::ComputeThinU);
    const Index kept = (svd.singularValues().array() > 0.5).count();
    unseen = scale.head(p).asDiagonal() * svd.matrixU().leftCols(kept);
  }
  estimate = scale.head(p).asDiagonal() * V.topRows(p) * inverse.asDiagonal() * V.transpose();
  covariance_of_u = scale.tail(m).asDiagonal() * V.bottomRows(m) * inverse.asDiagonal() *
                    V.bottomRows(m).transpose() * scale.tail(m).asDiagonal();
}

}  // namespace sixdial::diagnosis
