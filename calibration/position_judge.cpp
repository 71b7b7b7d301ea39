#include "calibration/position_judge.h"

#include <Eigen/Cholesky>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "calibration/reading_space.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastSigma_mm = 3e-4;  // rounding of a 0.001 mm display
/// Real structure is not as smooth as the random function that stands for it: so much of it
/// comes from pose to pose.
constexpr double kRoughShare = 0.1;

double chance_of(double squared, int axes, double freedom) {
  if (!(freedom > 0.0)) return 1.0;
  const boost::math::fisher_f distribution(axes, freedom);
  return boost::math::cdf(boost::math::complement(distribution, squared / axes));
}

}  // namespace

bool PositionJudge::can_judge(const ObservationSpace& space) {
  for (int i = 0; i < measured_samples(space); ++i) {
    if (space.rows(i) != space.position_axes) return false;
  }
  return true;
}

PositionJudge::PositionJudge(const ObservationSpace& space, const LeastSquaresFit& fit)
    : axes_(space.position_axes),
      measured_rows_(space.first_row[static_cast<std::size_t>(measured_samples(space))]),
      structure_(smooth_structure(space, fit, Weighting::kByCovariance)),
      x_(fit.x) {
  for (const MatrixXd& C : space.covariance_mm2) mean_variance_mm2_ += C.trace();
  mean_variance_mm2_ /= std::max(space.rows(), 1);
  const Index determined = fit.singular_values.size() - fit.held;
  to_determined_ = fit.scale.asDiagonal() * fit.directions.leftCols(determined);
  MatrixXd shapes(space.samples(), 0);
  if (structure_.sd_mm > 0.0) {
    basis_.emplace(space, structure_.over, structure_.length);
    shapes = (*basis_)(space);
  }
  B_.setZero(fit.J.rows(), determined + axes_ * shapes.cols());
  B_.leftCols(determined) = fit.J * to_determined_;
  for (int i = 0; i < measured_samples(space); ++i) {
    B_.block(
        space.first_row[static_cast<std::size_t>(i)], determined, axes_,
        axes_ * shapes.cols()) = whitening(space, i) * structure_columns(shapes.row(i));
  }
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
  if (sigma_mm_ > 0.0) rough_ = std::pow(kRoughShare * structure_.sd_mm / sigma_mm_, 2);
}

MatrixXd PositionJudge::whitening(const ObservationSpace& space, int sample) const {
  const auto k = static_cast<std::size_t>(sample);
  const MatrixXd I = MatrixXd::Identity(axes_, axes_);
  if (k >= space.covariance_mm2.size() || space.covariance_mm2[k].rows() != axes_) return I;
  const Eigen::LLT<MatrixXd> llt(space.covariance_mm2[k]);
  if (llt.info() != Eigen::Success || !(mean_variance_mm2_ > 0.0)) return I;
  return std::sqrt(mean_variance_mm2_) * llt.matrixL().solve(I).eval();
}

MatrixXd PositionJudge::structure_columns(const Eigen::RowVectorXd& shapes) const {
  MatrixXd columns = MatrixXd::Zero(axes_, axes_ * shapes.size());
  if (shapes.size() == 0) return columns;
  const double times = structure_.sd_mm / structure_.noise_mm;
  for (int axis = 0; axis < axes_; ++axis) {
    columns.block(axis, axis * shapes.size(), 1, shapes.size()) = times * shapes;
  }
  return columns;
}

std::vector<PositionJudge::Verdict> PositionJudge::each_by_the_others() const {
  std::vector<Verdict> verdicts;
  const double left = sigma_mm_ * sigma_mm_ * freedom_;
  const double freedom = freedom_ - axes_;
  const MatrixXd I = MatrixXd::Identity(axes_, axes_);
  for (Index row = 0; row + axes_ <= measured_rows_; row += axes_) {
    const auto B = B_.middleRows(row, axes_);
    const VectorXd r = residual_.segment(row, axes_);
    const MatrixXd kept = I - B * inverse_ * B.transpose();
    const Eigen::LDLT<MatrixXd> ldlt(kept);
    Verdict verdict;
    // A sample that alone determines something cannot be judged by the others.
    if (freedom > 0.0 && ldlt.isPositive() && ldlt.vectorD().minCoeff() > 1e-6) {
      const VectorXd e = ldlt.solve(r);
      const MatrixXd C = ldlt.solve(I) + rough_ * I;
      const double variance =
          std::max((left - r.dot(e)) / freedom, kLeastSigma_mm * kLeastSigma_mm);
      const double squared = e.dot(C.ldlt().solve(e)) / variance;
      verdict.size_mm = e.norm();
      verdict.times_sigma = std::sqrt(squared);
      verdict.chance = chance_of(squared, axes_, freedom);
    }
    verdicts.push_back(verdict);
  }
  return verdicts;
}

std::vector<PositionJudge::Verdict> PositionJudge::others(const ObservationSpace& space) const {
  const int samples = measured_samples(space);
  std::vector<Verdict> verdicts(static_cast<std::size_t>(samples));
  MatrixXd shapes(space.samples(), 0);
  if (basis_) shapes = (*basis_)(space);
  for (int i = 0; i < samples; ++i) {
    VectorXd e(axes_);
    MatrixXd J(axes_, x_.size());
    if (!space.evaluate(i, x_, e, &J)) continue;
    const MatrixXd W = whitening(space, i);
    MatrixXd B(axes_, B_.cols());
    B.leftCols(to_determined_.cols()) = J * to_determined_;
    B.rightCols(axes_ * shapes.cols()) = structure_columns(shapes.row(i));
    e = -e - B * coefficient_;  // as residuals are: predicted - measured
    // What the shapes do not reach is as uncertain as the structure is large.
    MatrixXd own = rough_ * MatrixXd::Identity(axes_, axes_);
    if (basis_) {
      const double times = structure_.sd_mm / structure_.noise_mm;
      own.diagonal().array() +=
          times * times * std::max(0.0, 1.0 - shapes.row(i).squaredNorm());
    }
    const MatrixXd C = MatrixXd::Identity(axes_, axes_) +
                       W * (B * inverse_ * B.transpose() + own) * W.transpose();
    const VectorXd white = W * e;
    const double squared = white.dot(C.ldlt().solve(white)) / (sigma_mm_ * sigma_mm_);
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
