#include "calibration/position_judge.h"

#include <Eigen/Cholesky>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastSigma_mm = 3e-4;  // rounding of a 0.001 mm display

double chance_of(double squared, int axes, double freedom) {
  if (!(freedom > 0.0)) return 1.0;
  const boost::math::fisher_f distribution(axes, freedom);
  return boost::math::cdf(boost::math::complement(distribution, squared / axes));
}

}  // namespace

PositionJudge::PositionJudge(const ObservationSpace& space, const LeastSquaresFit& fit)
    : axes_(space.position_axes),
      structure_(smooth_structure(space, fit, Weighting::kAlike)),
      x_(fit.x) {
  const Index determined = fit.singular_values.size() - fit.held;
  to_determined_ = fit.scale.asDiagonal() * fit.directions.leftCols(determined);
  MatrixXd shapes;
  if (structure_.sd_mm > 0.0) {
    basis_.emplace(space, structure_.over, structure_.length);
    shapes = (*basis_)(space);
  }
  B_ = design(space, fit.J, shapes);
  MatrixXd normal = B_.transpose() * B_;
  normal.diagonal().tail(B_.cols() - determined).array() += 1.0;  // N(0, 1) of each shape
  inverse_ = normal.ldlt().solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  coefficient_ = inverse_ * (B_.transpose() * fit.residual);
  residual_ = fit.residual - B_ * coefficient_;
  // Generalised least squares: r'(I - H)r is sigma^2 times chi-square of these, since the
  // structure is part of the rows' covariance.
  freedom_ = static_cast<double>(residual_.size() - determined);
  const double left = fit.residual.dot(residual_);
  sigma_mm_ = freedom_ > 0.0
                  ? std::max(std::sqrt(std::max(left, 0.0) / freedom_), kLeastSigma_mm)
                  : 0.0;
}

MatrixXd PositionJudge::design(
    const ObservationSpace& space, const MatrixXd& J, const MatrixXd& shapes) const {
  MatrixXd B = MatrixXd::Zero(J.rows(), to_determined_.cols() + shapes.cols() * axes_);
  B.leftCols(to_determined_.cols()) = J * to_determined_;
  if (shapes.cols() == 0) return B;
  const double times = structure_.sd_mm / structure_.noise_mm;
  for (int i = 0; i < space.samples(); ++i) {
    for (int axis = 0; axis < axes_; ++axis) {
      B.block(
          space.first_row[static_cast<std::size_t>(i)] + axis,
          to_determined_.cols() + axis * shapes.cols(), 1, shapes.cols()) =
          times * shapes.row(i);
    }
  }
  return B;
}

std::vector<PositionJudge::Verdict> PositionJudge::each_by_the_others() const {
  std::vector<Verdict> verdicts;
  const double left = sigma_mm_ * sigma_mm_ * freedom_;
  const double freedom = freedom_ - axes_;
  for (Index row = 0; row + axes_ <= residual_.size(); row += axes_) {
    const auto B = B_.middleRows(row, axes_);
    const auto r = residual_.segment(row, axes_);
    const MatrixXd kept = MatrixXd::Identity(axes_, axes_) - B * inverse_ * B.transpose();
    const Eigen::LDLT<MatrixXd> ldlt(kept);
    Verdict verdict;
    // A sample that alone determines something cannot be judged by the others.
    if (freedom > 0.0 && ldlt.isPositive() && ldlt.vectorD().minCoeff() > 1e-6) {
      const VectorXd e = ldlt.solve(VectorXd(r));
      const double squared = r.dot(e);
      const double variance =
          std::max((left - squared) / freedom, kLeastSigma_mm * kLeastSigma_mm);
      verdict.size_mm = e.norm();
      verdict.times_sigma = std::sqrt(squared / variance);
      verdict.chance = chance_of(squared / variance, axes_, freedom);
    }
    verdicts.push_back(verdict);
  }
  return verdicts;
}

std::vector<PositionJudge::Verdict> PositionJudge::others(const ObservationSpace& space) const {
  std::vector<Verdict> verdicts(static_cast<std::size_t>(space.samples()));
  MatrixXd shapes;
  if (basis_) shapes = (*basis_)(space);
  for (int i = 0; i < space.samples(); ++i) {
    VectorXd e(axes_);
    MatrixXd J(axes_, x_.size());
    if (!space.evaluate(i, x_, e, &J)) continue;
    MatrixXd B = MatrixXd::Zero(axes_, B_.cols());
    B.leftCols(to_determined_.cols()) = J * to_determined_;
    // The shapes of another sample's residual, as in design(): predicted - measured.
    for (int axis = 0; shapes.cols() > 0 && axis < axes_; ++axis) {
      B.block(axis, to_determined_.cols() + axis * shapes.cols(), 1, shapes.cols()) =
          structure_.sd_mm / structure_.noise_mm * shapes.row(i);
    }
    e = -e - B * coefficient_;
    MatrixXd C = MatrixXd::Identity(axes_, axes_) + B * inverse_ * B.transpose();
    if (basis_) {
      // What the shapes do not reach is as uncertain as the structure is large.
      const double times = structure_.sd_mm / structure_.noise_mm;
      const double unknown = std::max(0.0, 1.0 - shapes.row(i).squaredNorm());
      C.diagonal().array() += times * times * unknown;
    }
    const double squared = e.dot(C.ldlt().solve(e)) / (sigma_mm_ * sigma_mm_);
    auto& verdict = verdicts[static_cast<std::size_t>(i)];
    verdict.size_mm = e.norm();
    verdict.times_sigma = std::sqrt(squared);
    verdict.chance = chance_of(squared, axes_, freedom_);
  }
  return verdicts;
}

double PositionJudge::limit(double chance) const {
  const double freedom = freedom_ - axes_;
  if (!(freedom > 0.0)) return std::numeric_limits<double>::infinity();
  const boost::math::fisher_f distribution(axes_, freedom);
  return std::sqrt(
      axes_ * boost::math::quantile(boost::math::complement(distribution, chance)));
}

}  // namespace sixdial::calibration
