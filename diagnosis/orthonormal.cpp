#include "diagnosis/orthonormal.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "calibration/column_products.h"
#include "diagnosis/eliminated.h"

namespace sixdial::diagnosis {

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns, double relative) {
  Eigen::MatrixXd scaled = columns;
  for (Eigen::Index i = 0; i < scaled.cols(); ++i) {
    const double norm = scaled.col(i).norm();
    if (norm > 0) scaled.col(i) /= norm;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(relative);
  return qr.householderQ() * Eigen::MatrixXd::Identity(scaled.rows(), qr.rank());
}

Eigen::MatrixXd orthonormal_basis(
    const Eigen::MatrixXd& fitted, const Eigen::MatrixXd& random, const Eigen::VectorXd& root) {
  const Eigen::MatrixXd first = orthonormal_basis(fitted);
  const Eigen::Index n = fitted.rows();
  const Eigen::Index m = random.cols();
  if (m == 0) return first;
  const Eigen::Index p = first.cols();
  Eigen::MatrixXd rest(n + m, m);
  rest.topRows(n) = random - first * calibration::column_products(first, random);
  rest.bottomRows(m) = root.asDiagonal();
  const Eigen::VectorXd norm = rest.colwise().norm();
  rest *= norm.cwiseInverse().asDiagonal();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n + m, p + m);
  result.topLeftCorner(n, p) = first;
  // Twice: the second time removes what the first left by rounding.
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::LLT<Eigen::MatrixXd> llt(gram(rest));
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(rest);
  }
  result.rightCols(m) = rest;
  return result;
}

}  // namespace sixdial::diagnosis
