#include "diagnosis/orthonormal.h"

#include <Eigen/QR>

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

}  // namespace sixdial::diagnosis
