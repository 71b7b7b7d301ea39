#include "diagnosis/eliminated.h"

#include <algorithm>
#include <cmath>

#include "calibration/column_products.h"

namespace sixdial::diagnosis {
namespace {

// Of the largest eigenvalue of the scaled normal matrix: what is smaller is rounding.
constexpr double kUnseen = 1e-13;

}  // namespace

Eigen::MatrixXd gram(const Eigen::MatrixXd& A) { return calibration::column_products(A); }

EliminatedEquations::EliminatedEquations(
    const Eigen::MatrixXd& A, const Eigen::MatrixXd& C, const Eigen::VectorXd& e,
    const Eigen::VectorXd& root, const Eigen::VectorXd& u) {
  const Eigen::Index p = A.cols();
  const Eigen::Index m = C.cols();
  scale_ = A.colwise().norm().transpose().unaryExpr(
      [](double norm) { return norm > 0 ? 1.0 / norm : 0.0; });
  const Eigen::MatrixXd scaled = A * scale_.asDiagonal();
  Eigen::MatrixXd normal = gram(scaled);
  Eigen::VectorXd right = scaled.transpose() * e;
  share_.resize(m, p);
  at_rest_.resize(m);
  absorbed_ = Eigen::MatrixXd::Zero(p, p);
  if (m > 0) {
    Eigen::MatrixXd D = gram(C);
    D.diagonal() += root.cwiseAbs2();
    D_.compute(D);
    const Eigen::MatrixXd cross = calibration::column_products(C, scaled);
    const Eigen::VectorXd of_u = C.transpose() * e - root.cwiseAbs2().cwiseProduct(u);
    const Eigen::MatrixXd half = D_.matrixL().solve(cross);
    absorbed_ = gram(half);
    normal -= absorbed_;
    at_rest_ = D_.solve(of_u);
    share_ = D_.matrixU().solve(half);
    right -= cross.transpose() * at_rest_;
    fall_of_u_ = of_u.dot(at_rest_);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  if (p > 0) largest_ = std::max(1.0, values[p - 1]);
  const Eigen::Index count = (values.array() > kUnseen * largest_).count();
  seen_ = values.tail(count);
  vectors_ = eigen.eigenvectors().rightCols(count);
  along_ = vectors_.transpose() * right;
}

double EliminatedEquations::fall() const {
  return fall_of_u_ + along_.cwiseAbs2().cwiseQuotient(seen_).sum();
}

Eigen::VectorXd EliminatedEquations::step(double damping) const {
  const Eigen::VectorXd scaled =
      vectors_ * along_.cwiseQuotient((seen_.array() + damping * largest_).matrix());
  Eigen::VectorXd result(scaled.size() + at_rest_.size());
  result.head(scaled.size()) = scale_.cwiseProduct(scaled);
  result.tail(at_rest_.size()) = at_rest_ - share_ * scaled;
  return result;
}

Eigen::MatrixXd EliminatedEquations::covariance() const {
  const Eigen::MatrixXd own = scale_.asDiagonal() * vectors_;
  return own * seen_.cwiseInverse().asDiagonal() * own.transpose();
}

Eigen::VectorXd EliminatedEquations::variance_of_u() const {
  if (at_rest_.size() == 0) return {};
  const Eigen::MatrixXd alone =
      D_.solve(Eigen::MatrixXd::Identity(at_rest_.size(), at_rest_.size()));
  const Eigen::MatrixXd by_x = share_ * vectors_;
  return alone.diagonal() + by_x.cwiseAbs2() * seen_.cwiseInverse();
}

double EliminatedEquations::log_volume_of_u() const {
  if (at_rest_.size() == 0) return 0.0;
  // D^-1 + share S^-1 share' and its determinant, by that of the parameters' size.
  const Eigen::MatrixXd W = vectors_ * seen_.cwiseSqrt().cwiseInverse().asDiagonal();
  Eigen::MatrixXd rest = W.transpose() * absorbed_ * W;
  rest.diagonal().array() += 1.0;
  const Eigen::VectorXd of_rest = rest.ldlt().vectorD();
  return of_rest.array().max(1e-300).log().sum() -
         2.0 * D_.matrixLLT().diagonal().array().log().sum();
}

}  // namespace sixdial::diagnosis
